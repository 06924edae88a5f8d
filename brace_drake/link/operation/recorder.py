"""A device and a campaign's folder, for one recording after another."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from brace_drake.core.errors import StoppedError
from brace_drake.devices.motions.library import SafeMotion
from brace_drake.devices.motions.limits import check_reach
from brace_drake.link.operation.console import (
    CountDown,
    Keys,
    Say,
    describe_status,
)
from brace_drake.link.operation.journal import Journal, RunFile
from brace_drake.link.operation.motion import (
    RING,
    desired_at_ticks,
    place_motion,
)
from brace_drake.link.operation.rows import (
    Row,
    campaign_device,
    columns_of,
    name_values,
)
from brace_drake.link.operation.session import Session
from brace_drake.link.operation.station import MakeControl, OpenDevice
from brace_drake.link.protocol.limits import Limits
from brace_drake.link.protocol.messages import BAUD
from brace_drake.link.protocol.words import Cause
from brace_drake.scenario.brace import BraceScenario

# A recording begins at rest, as its twin does: torso and pads that were pressed
# before need so long to come to rest, s.
SETTLE = 4.0
# After these nothing is known of the device.
_OUT_OF_TOUCH = (Cause.DISCONNECTED, Cause.STALE_DATA, Cause.LOST_MESSAGES)


def campaign_head(
    scenario: BraceScenario, hello, settled: float, subject: str = ""
) -> dict:
    """Keys of campaign.yaml beside its runs.

    Args:
        scenario: Of the device.
        hello: What the device has told of itself.
        settled: s at rest before each run.
        subject: Who or what is in the brace.
    """
    device, stages = campaign_device(tuple(scenario.stages))
    who = ("model", "identity", "firmware", "rate_hz")
    head = {
        "device": device,
        "rate_hz": 1.0 / scenario.sensors.log_period,
        "subject": subject,
        "recorded": {name: getattr(hello, name) for name in who},
        "settled_s": settled,
    }
    if stages:
        head["stages"] = list(stages)
    return head


class Recorder:
    """Records motions of one device into one campaign.

    Attributes:
        link: To the device, agreed.
        journal: Of the campaign.
    """

    def __init__(
        self,
        port: str,
        scenario: BraceScenario,
        limits: Limits,
        out: str | Path,
        subject: str = "",
        baud: int = BAUD,
        clear: bool = False,
        ring: int = RING,
    ):
        """Opens the device and the folder.

        Args:
            port, baud: Of the device.
            scenario: What it must be, and its controller.
            limits: To agree on.
            out: The campaign's folder.
            subject: Of the campaign.
            clear: Whether a latched stop is to be ended.
            ring: That motions of one ring move.

        Raises:
            LinkError, LimitsError: As `OpenDevice`.
            OutputError, CampaignError: As `Journal`.
        """
        self._scenario, self._limits, self._ring = scenario, limits, ring
        self._rings = tuple(scenario.stages)
        self.link = OpenDevice(port, scenario, limits, baud, clear)
        try:
            hello = self.link.hello
            self._every = round(hello.rate_hz * scenario.sensors.log_period)
            head = campaign_head(scenario, hello, SETTLE, subject)
            self.journal = Journal(out, head)
        except BaseException:
            self.link.Close()
            raise

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_) -> None:
        self.journal.Close()
        self.link.Close()

    def Record(
        self,
        motion: SafeMotion,
        split: str,
        countdown: int,
        keys: Keys,
        repeat_of: str | None = None,
    ) -> RunFile:
        """Counts down, then follows a motion and writes it, as far as it came.

        Args:
            motion: What to do, of one ring or placed.
            split: What for.
            countdown: s.
            keys: One of them stops.
            repeat_of: File that it repeats, "" for none; None: that of the
                same motion and split, where there is one.

        Raises:
            LimitsError: The motion reaches further than any may.
            StoppedError: The operator, the supervisor or the device stopped;
                what had been recorded is in the campaign.
        """
        motion = place_motion(motion, self._rings, self._ring)
        check_reach(motion.name, motion.samples[:, 0])
        if repeat_of is None:
            repeat_of = self._Original(motion, split)
        control = MakeControl(self._scenario, self._limits)
        session = Session(self.link, control, self._limits)
        where = "with the torso" if motion.contact else "WITHOUT the torso"
        more = f" ({motion.meaning}), {where},"
        CountDown(countdown, motion.name, keys, more)
        run = self.journal.NewRun(
            motion.name, columns_of(self._rings), motion.contact, motion.kind,
            split, repeat_of or None,
        )  # fmt: skip
        try:
            self._Follow(session, motion, run, keys)
        finally:
            self.link.on_state = None
        if not session.done:
            Say(f"stopped, {_whereabouts(session)}", end=True)
            raise StoppedError(
                f"{run.entry['file']}: stopped after"
                f" {run.rows / self.journal.head['rate_hz']:.2f} s:"
                f" {session.stopped_by}"
            )
        Say(describe_status(1.0, session), end=True)
        return run

    def _Follow(
        self, session: Session, motion: SafeMotion, run: RunFile, keys: Keys
    ) -> None:
        """Follows a motion; every so many ticks become a row of the run."""
        columns, rate = columns_of(self._rings), self.link.hello.rate_hz
        desired = desired_at_ticks(motion, rate)
        begun = datetime.now(UTC).isoformat(timespec="seconds")

        def take(rows: list[Row]) -> None:
            for row in rows:
                if row.tick % self._every == 0:
                    values = name_values(row, self._rings)
                    values["time_s"] = row.tick / rate
                    # No zero with a sign.
                    run.Append([values[name] + 0.0 for name in columns])
            run.Flush()
            share = run.rows * self._every / len(desired)
            Say(describe_status(share, session))

        try:
            session.Follow(desired, take, keys.pressed, SETTLE)
        finally:
            line = self._DescribeLine(session)
            run.Close(session.done, {"begun": begun, **line})

    def _DescribeLine(self, session: Session) -> dict:
        """What campaign.yaml says of the line during a run."""
        tally, counts = session.tally, self.link.counts
        said = {
            "lost_messages": counts.lost,
            "bad_frames": counts.bad,
            "bridged_ticks": int(tally.bridged),
            "unanswered_ticks": int(tally.unanswered),
        }
        late = tally.latencies.percentiles(scale=1e6)
        if late:
            said["latency_us_50_99_999"] = [round(v) for v in late]
        if session.trip is not None:
            said["stopped"] = str(session.trip)
        return said

    def _Original(self, motion: SafeMotion, split: str) -> str | None:
        """The whole recording of a motion that another one repeats."""
        for item in self.journal.runs:
            same = item["file"] == f"{motion.name}.csv"
            if same and item["split"] == split and item.get("complete", True):
                return item["file"]
        return None


def _whereabouts(session: Session) -> str:
    """What is known of the ring after a stop."""
    if session.trip is not None and session.trip.cause in _OUT_OF_TOUCH:
        return "no contact with the device: its own watchdog has to release it"
    return "the ring is released"
