"""Recording a motion from a device into a campaign."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime

from brace_drake.campaign.columns import DEVICES
from brace_drake.errors import StoppedError
from brace_drake.hardware.link import Link
from brace_drake.operation.journal import Journal, RunFile
from brace_drake.operation.session import Row, Session
from brace_drake.operation.watch import WatchSession
from brace_drake.twin.motion_library import SafeMotion
from brace_drake.twin.reference import reference_at_ticks

# Beside the channels of the device's format.
_EXTRA = ("bridged", "command_age_ticks", "latency_us")
# A recording begins at rest, as its twin does: torso and pads that were pressed
# before need so long to come to rest, s.
_SETTLE = 4.0


def describe_device(link: Link) -> dict:
    """What campaign.yaml says of the device that recorded."""
    hello = link.hello
    return {
        "model": hello.model,
        "identity": hello.identity,
        "firmware": hello.firmware,
        "rate_hz": float(hello.rate_hz),
    }


def columns_of(device: str) -> tuple[str, ...]:
    """Columns of a recording through the link."""
    return (*DEVICES[device], *_EXTRA)


def arrange_row(row: Row, period: float, device: str) -> list[float]:
    """A tick's numbers in the order of `columns_of`."""
    values = {"time_s": row.tick * period, "ring2_y_virtual_m": row.y_virtual}
    for k in range(6):
        values[f"leg{k + 1}_force_command_N"] = row.command[k]
        values[f"leg{k + 1}_length_m"] = row.readings[k]
    for i, axis in enumerate("xyz"):
        values[f"ring2_force_{axis}_N"] = row.readings[6 + i]
        values[f"torso_{axis}_m"] = row.readings[9 + i]
    for i, name in enumerate(("y_desired_m", "vy_desired_m_s")):
        values[f"ring2_{name}"] = row.desired[i]
    values["ring2_ay_desired_m_s2"] = row.desired[2]
    ordered = [float(values[name]) + 0.0 for name in DEVICES[device]]
    return [*ordered, row.bridged, row.age, round(1e6 * row.latency)]


def RecordMotion(
    link: Link,
    session: Session,
    journal: Journal,
    motion: SafeMotion,
    split: str = "fit",
    repeat_of: str | None = None,
    asks_stop: Callable[[], bool] = lambda: False,
    tell: Callable[[float, Session], None] = lambda share, session: None,
    settle: float = _SETTLE,
) -> RunFile:
    """Follows a motion and writes it as a run, as far as it came.

    Args:
        link: Agreed.
        session: Fresh, on this link.
        journal: Of the campaign.
        motion: The reference.
        split, repeat_of: Of the run.
        asks_stop: Whether the operator wants it stopped.
        tell: Called with the share done, now and then.
        settle: How long the ring is held at rest before, s.

    Raises:
        StoppedError: It was stopped before its end; what had been recorded is
            in the campaign.
    """
    device, rate = journal.head["device"], link.hello.rate_hz
    every = round(rate / journal.head["rate_hz"])
    desired = reference_at_ticks(motion.time, motion.samples, rate)
    run = journal.NewRun(
        motion.name,
        columns_of(device),
        motion.contact,
        motion.kind,
        split,
        repeat_of,
    )
    begun = datetime.now(UTC).isoformat(timespec="seconds")

    def take(rows: list[Row]) -> None:
        for row in rows:
            if row.tick % every == 0:
                run.Append(arrange_row(row, 1.0 / rate, device))
        run.Flush()
        tell(run.rows * every / len(desired), session)

    session.Start(desired, settle)
    try:
        WatchSession(session, take, asks_stop)
    finally:
        run.Close(
            session.done, {"begun": begun, **_describe_line(link, session)}
        )
    if not session.done:
        words = str(session.trip) if session.trip else str(link.error)
        raise StoppedError(
            f"{run.entry['file']}: stopped after"
            f" {run.rows * every / rate:.2f} s: {words}"
        )
    session.Finish()
    return run


def _describe_line(link: Link, session: Session) -> dict:
    """What campaign.yaml says of the line during a run."""
    tally, counts = session.tally, link.counts
    said = {
        "lost_messages": counts.lost,
        "bad_frames": counts.bad,
        "bridged_ticks": int(tally.bridged),
        "unanswered_ticks": int(tally.unanswered),
    }
    late = tally.latencies.percentiles()
    if late:
        said["latency_us_50_99_999"] = [round(1e6 * v) for v in late]
    if session.trip is not None:
        said["stopped"] = str(session.trip)
    return said
