"""Since when a device is not as expected, and why, while it runs."""

from __future__ import annotations

import contextlib
import shlex
import time
from collections.abc import Callable, Iterator
from functools import partial

from brace_drake.link.operation.live.cycles_kept import CyclesKept
from brace_drake.link.operation.live.naming import NamingProcess
from brace_drake.link.operation.recorder import campaign_head
from brace_drake.link.operation.rows import Row
from brace_drake.monitoring.cycles import REST
from brace_drake.monitoring.prepare import Expected

# Causes that are shown; seconds between questions, and after an onset.
SHOWN, _PAUSE, _FIRST = 3, 5.0, 2.0


class Observer:
    """Watches the differences of a device and its twin.

    Attributes:
        watch: Since when they are not as expected.
        is_whole: Whether the motion has come to its end.
    """

    def __init__(
        self,
        expected: Expected,
        naming: NamingProcess,
        kept: CyclesKept,
        command: Callable[[str], str],
        say: Callable[[str], None] = print,
    ):
        """Begins with the first tick.

        Args:
            expected: Of the device.
            naming: Names causes.
            kept: Keeps the recording.
            command: From a campaign's folder to what diagnoses it in full.
            say: Takes lines for the terminal.
        """
        self.watch = expected.watch()
        self._naming, self._kept, self._say = naming, kept, say
        self._command, self._rate = command, expected.rate
        self._every = expected.motion.ticks_per_sample
        self._onset: int | None = None
        self._since = ""
        self._asked, self._first = 0, ""
        self._learnt = self.is_whole = False

    def Take(self, tick: int, difference) -> None:
        """Takes the difference of a tick (C,), in order."""
        if tick % self._every == 0:
            self.watch.Take(difference)

    def Look(self, rows: list[Row]) -> None:
        """Keeps the last ticks, tells what is new, and asks for causes where it
        is time.

        Raises:
            OutputError: The disk takes no more.
        """
        self._kept.Take(rows)
        watch, naming = self.watch, self._naming
        if not self._learnt and not watch.is_learning:
            self._learnt = True
            if watch.differs:
                self._say(
                    "usual: not as the twin from the beginning; a diagnosis"
                    " tells why; watched for changes"
                )
        if watch.onset is None:
            if self._onset is not None:
                self._say(f"{self._Clock(watch.count)} as expected again")
                naming.Forget()
            self._onset, self._asked, self._first = None, 0, ""
            return
        if self._onset is None:
            self._onset, self._since = watch.onset, self._Clock(watch.onset)
            naming.Forget()
            self._kept.Change()
            told = (watch.alarm - watch.onset) / self._rate
            self._say(
                f"{self._since} not as expected (told {told:.1f} s later)"
            )
        self._Ask()
        if naming.causes and naming.causes[0].name != self._first:
            self._first = naming.causes[0].name
            said = "; ".join(map(_describe, naming.causes[:SHOWN]))
            self._say(f"{self._Clock(watch.count)} likeliest: {said}")

    def _Ask(self) -> None:
        watch, naming = self.watch, self._naming
        pause = _PAUSE if self._asked else 0.0
        due = max(
            self._asked + pause * self._rate,
            watch.onset + _FIRST * self._rate,
        )
        if watch.count < due or naming.is_busy:
            return
        since = watch.since()
        if since is not None and len(since.rows) > naming.seen:
            self._asked = watch.count
            naming.Ask(since)

    def _Clock(self, sample: int) -> str:
        """The time of day of a sample, as long ago as it is."""
        ago = (self.watch.count - sample) / self._rate
        return time.strftime("%H:%M:%S", time.localtime(time.time() - ago))

    def describe(self) -> dict:
        """What a page shows."""
        watch, kept = self.watch, self._kept
        state = "expected" if watch.onset is None else "changed"
        folder = kept.since or kept.folder
        return {
            "state": "learning" if watch.is_learning else state,
            "since": "" if watch.onset is None else self._since,
            "causes": [
                {
                    "name": c.name,
                    "title": c.title,
                    "share": c.share,
                    "probability": c.probability,
                }
                for c in (
                    self._naming.causes[:SHOWN] if state == "changed" else ()
                )
            ],
            "seen_s": self._naming.seen / self._rate,
            "folder": str(folder),
            "command": self._command(str(folder)),
        }


@contextlib.contextmanager
def OpenObserver(
    expected: Expected | None, folder: str, hello, scenario: str | None = None
) -> Iterator[Observer | None]:
    """An observer with its folder and its process; None without what is
    expected.

    Args:
        expected: Of the device.
        folder: Of the campaign.
        hello: What the device has told of itself.
        scenario: File of the twin's scenario, where it is not the package's.

    Raises:
        OutputError, CampaignError: As `Journal`.
    """
    if expected is None:
        yield None
        return

    def command(path: str) -> str:
        more = ["--scenario", scenario] if scenario else []
        return shlex.join(["brace-drake", "diagnose", path, *more])

    every = expected.motion.ticks_per_sample
    kept = CyclesKept(
        folder,
        campaign_head(expected.scenario, hello, settled=REST),
        expected.cycle,
        tuple(expected.scenario.stages),
        hello.rate_hz,
        every,
    )
    observer = None
    try:
        with NamingProcess(expected) as naming:
            say = partial(print, flush=True)
            observer = Observer(expected, naming, kept, command, say)
            yield observer
    finally:
        kept.Close(observer is not None and observer.is_whole)
        if kept.files:
            print(f"kept: {command(str(kept.since or kept.folder))}")


def _describe(cause) -> str:
    return f"{cause.name} ({cause.probability:.0%}, explains {cause.share:.0%})"
