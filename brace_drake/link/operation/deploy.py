"""A controller on a device: dry first, then armed, watched all the time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from brace_drake.core.csv_text import csv_text
from brace_drake.core.errors import StoppedError
from brace_drake.core.output import WriteJson, WriteText
from brace_drake.link.host.link import Link
from brace_drake.link.operation.rows import (
    Rings,
    Row,
    log_columns,
    name_values,
)
from brace_drake.link.operation.session import Session
from brace_drake.link.operation.tally import Tally
from brace_drake.link.protocol.limits import Limits

# What a dry run must show before anything is armed.
_LEAST_DRY, _MOST_LATE = 200, 1.0


def RunController(
    link: Link,
    control,
    limits: Limits,
    desired: np.ndarray,
    dry_run: bool,
    asks_stop: Callable[[], bool] = lambda: False,
    keep: Callable[[Session, list[Row], str], None] = lambda *_: None,
) -> Session:
    """Runs a controller over a reference.

    Args:
        link: Agreed.
        control: With `Tick(readings, desired)`, as `HostControl`.
        limits: Of the supervisor.
        desired: y_d, y_d', y_d'' at each tick (ticks, 3, S).
        dry_run: Commands are computed and judged, but the device stays
            disarmed.
        asks_stop: Of the operator's console.
        keep: Called once, however it ends, with the session, its ticks and
            what ended it before its end, "" for nothing.

    Raises:
        StoppedError: It was stopped before its end.
        LinkError: The device refuses to arm, or to disarm.
        LimitsError: The reference reaches further than any may.
    """
    session = Session(link, control, limits, dry_run)
    rows: list[Row] = []
    cause = ""
    try:
        session.Follow(desired, rows.extend, asks_stop)
        if session.trip is not None or not session.done:
            raise StoppedError(
                f"stopped after {len(rows)} ticks: {session.stopped_by}"
            )
    except BaseException as error:
        cause = str(error) or type(error).__name__
        raise
    finally:
        link.on_state = None
        keep(session, rows, cause)
    return session


class RunLog:
    """A folder with the last run's ticks and the timing of all.

    ticks.csv is what `format_log` writes; timing.json has the tally of each
    run, and `stopped`, why, where one did not come to its end.
    """

    def __init__(self, folder: Path, rings: Rings):
        self._folder, self._timing, self._rings = folder, {}, rings

    def Write(
        self, name: str, session: Session, rows: list[Row], cause: str
    ) -> None:
        """Writes a run of this name; the rest as `RunController` gives it."""
        said = session.tally.describe()
        self._timing[name] = said | ({"stopped": cause} if cause else {})
        WriteText(self._folder / "ticks.csv", format_log(rows, self._rings))
        WriteJson(self._folder / "timing.json", self._timing)


def check_dry_run(tally: Tally) -> None:
    """Refuses to arm after a dry run that kept no time.

    Raises:
        StoppedError: Says what was too slow.
    """
    if tally.ticks < _LEAST_DRY:
        raise StoppedError(f"the dry run had {tally.ticks} ticks only")
    period = 1e6 * tally.periods.mean
    late = tally.latencies.percentiles(scale=1e6)[1]
    if late > _MOST_LATE * period:
        raise StoppedError(
            f"not armed: in the dry run 1 % of the answers took {late:.0f} us"
            f" or more, a tick has {period:.0f}"
        )


def format_log(rows: Sequence[Row], rings: Rings) -> str:
    """Ticks as CSV text: tick, commands, readings, reference, timing."""
    columns = log_columns(rings)
    named = (name_values(row, rings) for row in rows)
    cells = ([f"{v[name]:.8g}" for name in columns] for v in named)
    return csv_text(columns, cells)
