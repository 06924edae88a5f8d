"""Recording a motion from a device into a campaign."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime

from brace_drake.core.errors import StoppedError
from brace_drake.devices.motions.library import SafeMotion
from brace_drake.link.device.link import Link
from brace_drake.link.operation.columns import arrange_row, columns_of
from brace_drake.link.operation.journal import Journal, RunFile
from brace_drake.link.operation.motion import desired_at_ticks
from brace_drake.link.operation.rows import Row
from brace_drake.link.operation.session import Session
from brace_drake.link.operation.watch import WatchSession

# A recording begins at rest, as its twin does: torso and pads that were pressed
# before need so long to come to rest, s.
SETTLE = 4.0


def describe_device(link: Link) -> dict:
    """What campaign.yaml says of the device that recorded."""
    hello = link.hello
    return {
        "model": hello.model,
        "identity": hello.identity,
        "firmware": hello.firmware,
        "rate_hz": float(hello.rate_hz),
    }


def RecordMotion(
    link: Link,
    session: Session,
    journal: Journal,
    motion: SafeMotion,
    split: str = "fit",
    repeat_of: str | None = None,
    asks_stop: Callable[[], bool] = lambda: False,
    tell: Callable[[float, Session], None] = lambda share, session: None,
    settle: float = SETTLE,
) -> RunFile:
    """Follows a motion and writes it as a run, as far as it came.

    Args:
        link: Agreed.
        session: Fresh, on this link.
        journal: Of the campaign.
        motion: The reference, of several rings placed on them.
        split, repeat_of: Of the run.
        asks_stop: Whether the operator wants it stopped.
        tell: Called with the share done, now and then.
        settle: How long the rings are held at rest before, s.

    Raises:
        StoppedError: It was stopped before its end; what had been recorded is
            in the campaign.
    """
    device, stages = journal.head["device"], journal.stages
    rate = link.hello.rate_hz
    every = round(rate / journal.head["rate_hz"])
    desired = desired_at_ticks(motion, rate)
    run = journal.NewRun(
        motion.name,
        columns_of(device, stages),
        motion.contact,
        motion.kind,
        split,
        repeat_of,
    )
    begun = datetime.now(UTC).isoformat(timespec="seconds")

    def take(rows: list[Row]) -> None:
        for row in rows:
            if row.tick % every == 0:
                run.Append(arrange_row(row, 1.0 / rate, device, stages))
        run.Flush()
        tell(run.rows * every / len(desired), session)

    session.Start(desired, settle)
    try:
        WatchSession(session, take, asks_stop)
        # Before the last rows: a full disk must not keep the ring pressed.
        if session.done:
            session.Finish()
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
