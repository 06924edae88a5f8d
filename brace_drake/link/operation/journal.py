"""A campaign that is valid at every moment of its recording.

Rows are appended as they come and put onto the disk at least four times a
second. Every row has the same length, a power of two no longer than a page of
the disk's cache, and begins at a multiple of it: a process that is killed in
the middle of a write leaves whole rows, and what a full disk has taken of a row
is cut off again. A run enters campaign.yaml with its first rows, and
campaign.yaml is replaced, never changed. One process at a time records into a
folder.
"""

from __future__ import annotations

import contextlib
import errno
import os
import time
from collections import deque
from pathlib import Path

import yaml

from brace_drake.core.errors import CampaignError, OutputError, quoted
from brace_drake.core.output import HoldFolder, ReleaseFolder, WriteText
from brace_drake.core.reading import LoadYaml
from brace_drake.recording.columns import split_unit
from brace_drake.recording.fields import TEXT, take
from brace_drake.recording.manifest import FORMAT, MANIFEST
from brace_drake.recording.write import DECIMALS

_PAGE = 4096
_SYNC = 0.25
_ITEM = {
    name: TEXT._replace(required=True) for name in ("file", "motion", "split")
}


class Journal:
    """A campaign folder that runs are added to.

    Attributes:
        folder: Where it is.
        head: Keys of campaign.yaml beside `runs`.
    """

    def __init__(self, folder: str | Path, head: dict):
        """Opens or makes a campaign folder.

        Args:
            folder: An existing campaign of the same device and rate, an empty
                folder, or one to be made.
            head: Of campaign.yaml: `device`, `rate_hz`, `subject`, `recorded`
                (with what), and `stages` and `settled_s` where they are told.

        Raises:
            OutputError: The folder cannot be written, or another process
                holds it.
            CampaignError: It holds something else.
        """
        self._is_new = not os.path.exists(folder)
        self.folder = HoldFolder(Path(folder))
        self.head = {"format": FORMAT} | head
        self._runs: list[dict] = []
        path = self.folder / MANIFEST
        if path.exists():
            self._Continue(path)
        elif any(self.folder.glob("*.csv")):
            raise CampaignError(f"{folder}: holds CSV files, but no {MANIFEST}")

    def Close(self) -> None:
        """Lets other processes record; a new folder goes if it is empty."""
        ReleaseFolder(self.folder)
        if self._is_new:
            with contextlib.suppress(OSError):
                self.folder.rmdir()

    def _Continue(self, path: Path) -> None:
        content = LoadYaml(path, CampaignError)
        runs = content.get("runs")
        runs = runs if isinstance(runs, list) else [runs]
        for number, run in enumerate(runs, 1):
            if not isinstance(run, dict) or take(run, _ITEM)[1]:
                raise CampaignError(
                    f"{path}: cannot be continued: run {number} is"
                    f" {quoted(run)}; allowed: {', '.join(_ITEM)}"
                )
        for key in ("device", "rate_hz", "recorded", "stages", "settled_s"):
            mine, there = self.head.get(key), content.get(key)
            if mine != there:
                raise CampaignError(
                    f"{path}: {key} is {quoted(there)}, this recording's is"
                    f" {mine!r}"
                )
        self.head["subject"] = content.get("subject", "")
        self._runs = runs

    @property
    def runs(self) -> list[dict]:
        """Items of campaign.yaml so far."""
        return list(self._runs)

    @property
    def files(self) -> list[str]:
        """Names of the runs' files so far."""
        return [run["file"] for run in self._runs]

    def NewRun(
        self,
        name: str,
        columns: tuple[str, ...],
        contact: bool,
        motion: str,
        split: str,
        repeat_of: str | None = None,
    ) -> RunFile:
        """A run that rows can be added to."""
        number, file = 1, f"{name}.csv"
        while (self.folder / file).exists():
            number += 1
            file = f"{name}_{number}.csv"
        entry = {
            "file": file,
            "contact": bool(contact),
            "motion": motion,
            "repeat_of": repeat_of,
            "split": split,
            "complete": False,
        }
        return RunFile(self, entry, columns)

    def Enter(self, entry: dict) -> None:
        """Writes campaign.yaml with this run in it."""
        is_new = entry not in self._runs
        runs = [*self._runs, entry] if is_new else self._runs
        content = {**self.head, "runs": runs}
        text = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
        WriteText(self.folder / MANIFEST, text)
        self._runs = runs


class RunFile:
    """One run, row by row.

    Attributes:
        rows: Written so far.
        entry: Its item of campaign.yaml.
    """

    def __init__(self, journal: Journal, entry: dict, columns):
        self.rows, self.entry = 0, entry
        self._journal = journal
        self._path = journal.folder / entry["file"]
        formats = []
        for name in columns:
            decimals = DECIMALS.get(split_unit(name)[1])
            formats.append("%d" if decimals is None else f"%.{decimals}f")
        self._format = ",".join(formats)
        # Room for a sign and five figures in front of the decimals.
        widest = sum(
            7 + DECIMALS.get(split_unit(name)[1], 4) for name in columns
        ) + len(columns)
        self._width = 1 << max(6, (widest - 1).bit_length())
        if self._width > _PAGE:
            raise OutputError(f"{self._path}: rows of {widest} characters")
        header = ",".join(columns)
        room = -(-(len(header) + 1) // self._width) * self._width
        self._pending = deque([header.ljust(room - 1) + "\n"])
        self._fd: int | None = None
        self._size = 0
        self._synced = time.monotonic()
        self._entered = False

    def Append(self, values) -> None:
        """Takes a row; it is on the disk after the next `Flush`."""
        text = self._format % tuple(values)
        if len(text) >= self._width:
            raise OutputError(f"{self._path}: a row is too long: {text}")
        self._pending.append(text.ljust(self._width - 1) + "\n")
        self.rows += 1

    def Flush(self, now: bool = False) -> None:
        """Writes what is due: each quarter of a second, or now.

        Raises:
            OutputError: The disk takes no more. What it has taken is whole rows
                of a run in campaign.yaml, or no run at all; what it has not is
                written by the next call that succeeds.
        """
        due = time.monotonic() - self._synced > _SYNC
        if not (due or now) or self.rows < 2:
            return
        try:
            if self._fd is None:
                flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND
                self._fd = os.open(self._path, flags, 0o644)
            self._WriteRows(self._fd)
            os.fsync(self._fd)
            if not self._entered:
                self._journal.Enter(self.entry)
                self._entered = True
        except OSError as error:
            raise OutputError(f"{self._path}: {error.strerror}") from error
        self._synced = time.monotonic()

    def _WriteRows(self, fd: int) -> None:
        while self._pending:
            row = self._pending[0].encode("ascii")
            if os.write(fd, row) < len(row):
                os.ftruncate(fd, self._size)
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self._size += len(row)
            self._pending.popleft()

    def Close(self, complete: bool, notes: dict) -> None:
        """Ends the run; `notes` go into its item of campaign.yaml.

        Raises:
            OutputError: The disk takes no more; the run is left as it is
                there, incomplete.
        """
        try:
            self.Flush(now=True)
            if self._fd is not None:
                self.entry.update(complete=complete, **notes)
                self._journal.Enter(self.entry)
        finally:
            self._Leave()

    def _Leave(self) -> None:
        if self._fd is None:
            return
        os.close(self._fd)
        self._fd = None
        if not self._entered:
            # Nobody would know what motion these rows are of.
            with contextlib.suppress(OSError):
                self._path.unlink()
