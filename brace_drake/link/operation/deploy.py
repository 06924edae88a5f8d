"""A controller on a device: dry first, then armed, watched all the time."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from brace_drake.core.errors import LinkError, StoppedError
from brace_drake.core.output import WriteJson, WriteText
from brace_drake.link.device.limits import Limits
from brace_drake.link.device.link import Link
from brace_drake.link.operation.columns import leg_names
from brace_drake.link.operation.motion import RING
from brace_drake.link.operation.rows import Row
from brace_drake.link.operation.session import Session
from brace_drake.link.operation.watch import WatchSession

# What a dry run must show before anything is armed.
_LEAST_DRY, _MOST_LATE = 200, 1.0


@dataclass
class Timing:
    """How well a run kept its time.

    Attributes:
        ticks: Controlled.
        rate_hz: Of them.
        unanswered, bridged: Ticks that went by on the last command; states
            that never came.
        latency_us, period_us, age_ticks: 50, 99, 99.9 %.
    """

    ticks: int
    rate_hz: float
    unanswered: int
    bridged: int
    latency_us: list[float] = field(default_factory=list)
    period_us: list[float] = field(default_factory=list)
    age_ticks: list[float] = field(default_factory=list)

    def __str__(self) -> str:
        def three(values):
            return " / ".join(f"{v:.0f}" for v in values)

        return (
            f"{self.ticks} ticks at {self.rate_hz:.0f} Hz;"
            f" answers {three(self.latency_us)} us,"
            f" periods {three(self.period_us)} us,"
            f" ages {three(self.age_ticks)} ticks (50, 99, 99.9 %);"
            f" unanswered {self.unanswered}, bridged {self.bridged}"
        )


def measure_timing(session: Session) -> Timing:
    """The timing of a session so far."""
    tally = session.tally

    def at(spread, scale=1.0):
        return [scale * value for value in spread.percentiles()]

    mean = tally.periods.mean
    return Timing(
        tally.ticks,
        1.0 / mean if mean > 0.0 else 0.0,
        tally.unanswered,
        tally.bridged,
        at(tally.latencies, 1e6),
        at(tally.periods, 1e6),
        at(tally.ages),
    )


def RunController(
    link: Link,
    control,
    limits: Limits,
    desired: np.ndarray,
    dry_run: bool,
    asks_stop: Callable[[], bool] = lambda: False,
    keep: Callable[[Session, list[Row], str], None] = lambda *_: None,
    rings: Sequence[int] = (RING,),
) -> tuple[Session, str]:
    """Runs a controller over a reference.

    Args:
        link: Agreed.
        control: With `Tick(readings, desired)`, as `HostControl`.
        limits: Of the supervisor.
        desired: y_d, y_d', y_d'' at each tick (ticks, 3), of several rings
            (ticks, 3, S).
        dry_run: Commands are computed and judged, but the device stays
            disarmed.
        asks_stop: Of the operator's console.
        keep: Called once, however it ends, with the session, its ticks and
            what ended it before its end, "" for nothing.
        rings: Numbers of the moving rings, bottom to top.

    Returns:
        The session, and a log of all ticks as CSV text.

    Raises:
        StoppedError: It was stopped before its end.
        LinkError: The device refuses to arm, or to disarm.
        LimitsError: The reference reaches further than any may.
    """
    session = Session(link, control, limits, dry_run)
    rows: list[Row] = []
    cause = ""
    try:
        session.Start(desired)
        WatchSession(session, rows.extend, asks_stop)
        if session.trip is not None or not session.done:
            words = _describe_stop(session, link)
            raise StoppedError(f"stopped after {len(rows)} ticks: {words}")
        session.Finish()
    except BaseException as error:
        cause = str(error) or type(error).__name__
        raise
    finally:
        link.on_state = None
        keep(session, rows, cause)
    return session, format_log(rows, rings)


def _describe_stop(session: Session, link: Link) -> str:
    """What stopped a session, with the words of an error of our own."""
    error = link.error
    told = error is None or isinstance(error, LinkError)
    return str(session.trip or error) + ("" if told else f": {error}")


class RunLog:
    """A folder with the last run's ticks and the timing of all.

    ticks.csv is what `format_log` writes; timing.json has a `Timing` for each
    run, and `stopped`, why, where one did not come to its end.
    """

    def __init__(self, folder: Path, rings: Sequence[int] = (RING,)):
        self._folder, self._timing, self._rings = folder, {}, rings

    def keep(self, name: str) -> Callable[[Session, list[Row], str], None]:
        """What `RunController` is to call with a run of this name."""

        def Write(session: Session, rows: list[Row], cause: str) -> None:
            said = asdict(measure_timing(session))
            self._timing[name] = said | ({"stopped": cause} if cause else {})
            WriteText(self._folder / "ticks.csv", format_log(rows, self._rings))
            WriteJson(self._folder / "timing.json", self._timing)

        return Write


def check_dry_run(timing: Timing) -> None:
    """Refuses to arm after a dry run that kept no time.

    Raises:
        StoppedError: Says what was too slow.
    """
    if timing.ticks < _LEAST_DRY:
        raise StoppedError(f"the dry run had {timing.ticks} ticks only")
    period = 1e6 / timing.rate_hz
    late = timing.latency_us[1]
    if late > _MOST_LATE * period:
        raise StoppedError(
            f"not armed: in the dry run 1 % of the answers took {late:.0f} us"
            f" or more, a tick has {period:.0f}"
        )


def format_log(rows, rings: Sequence[int] = (RING,)) -> str:
    """Ticks as CSV text: tick, commands, readings, reference, timing."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    legs = leg_names(rings)
    head = ["tick", *(f"{leg}_force_command_N" for leg in legs)]
    head += [f"{leg}_length_m" for leg in legs]
    head += [f"ring{i}_force_{a}_N" for i in rings for a in "xyz"]
    for i in rings:
        head += [f"ring{i}_y_desired_m", f"ring{i}_y_virtual_m"]
        head += [f"ring{i}_y_m", f"ring{i}_y_stiffness_N_m"]
    writer.writerow([*head, "latency_us", "command_age_ticks", "bridged"])
    for row in rows:
        y_desired = np.reshape(row.desired, (3, -1))[0]
        of_rings = (y_desired, row.y_virtual, row.y_ring, row.stiffness)
        values = [*row.command, *row.readings[:-3]]
        values += np.transpose(of_rings).ravel().tolist()
        writer.writerow(
            [
                row.tick,
                *(f"{v:.8g}" for v in values),
                round(1e6 * row.latency),
                row.age,
                int(row.bridged),
            ]
        )
    return out.getvalue()
