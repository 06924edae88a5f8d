"""The cycles of a motion that is repeated, each a run of a campaign.

Cycles until one in which something has changed are one campaign. Those that
begin after the change are another, in a folder inside: in each campaign the
machine is the same in all runs.
"""

from __future__ import annotations

from pathlib import Path

from brace_drake.devices.motions.library import SafeMotion
from brace_drake.link.operation.journal import Journal, RunFile
from brace_drake.link.operation.rows import Rings, Row, columns_of, name_values

SINCE = "since"


class CyclesKept:
    """Writes the ticks of a session into the runs of campaigns.

    Attributes:
        folder: Of the campaign until a change.
        since: Of the one after it; None before its first run is whole.
    """

    def __init__(
        self,
        folder: str | Path,
        head: dict,
        cycle: SafeMotion,
        rings: Rings,
        rate: float,
        every: int,
    ):
        """Opens the folder.

        Args:
            folder: New, empty, or a campaign of the same device to continue.
            head: Of campaign.yaml, see `Journal`.
            cycle: The motion.
            rings: Of the device.
            rate: Of the ticks, Hz.
            every: Ticks in a sample.

        Raises:
            OutputError, CampaignError: As `Journal`.
        """
        self._head, self._cycle, self._rings = head, cycle, rings
        self._rate, self._every = rate, every
        self._length = len(cycle.time) * every
        self._journals = [Journal(folder, head)]
        self._run: RunFile | None = None
        self._changed = False
        self.folder, self.since = Path(folder), None

    @property
    def files(self) -> list[str]:
        """Names of all runs that are in a campaign."""
        return [name for journal in self._journals for name in journal.files]

    def Change(self) -> None:
        """From the next cycle on the machine is another one."""
        self._changed = True

    def Take(self, rows: list[Row]) -> None:
        """Takes ticks, in order.

        Raises:
            OutputError: The disk takes no more.
        """
        columns = columns_of(self._rings)
        for row in rows:
            tick = row.tick % self._length
            if tick == 0:
                self._Next()
            if tick % self._every == 0 and self._run is not None:
                values = name_values(row, self._rings)
                values["time_s"] = tick / self._rate
                # No zero with a sign.
                self._run.Append([values[name] + 0.0 for name in columns])
        if self._run is not None:
            self._run.Flush()

    def _Next(self) -> None:
        self._End(True)
        if self._changed and len(self._journals) == 1:
            self._journals.append(Journal(self.folder / SINCE, self._head))
        journal, cycle = self._journals[-1], self._cycle
        whole = [r["file"] for r in journal.runs if r.get("complete", True)]
        self._run = journal.NewRun(
            cycle.name, columns_of(self._rings), cycle.contact, cycle.kind,
            "fit", whole[0] if whole else None,
        )  # fmt: skip

    def _End(self, complete: bool) -> None:
        run, self._run = self._run, None
        if run is not None:
            run.Close(complete, {})
        if len(self._journals) > 1 and self._journals[-1].files:
            self.since = self.folder / SINCE

    def Close(self, complete: bool) -> None:
        """Ends the last run; `complete`: whether the motion came to its end."""
        try:
            self._End(complete)
        finally:
            for journal in self._journals[::-1]:
                journal.Close()
