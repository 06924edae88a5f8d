"""A device and a campaign's folder, for one recording after another."""

from __future__ import annotations

from pathlib import Path

from brace_drake.core.errors import StoppedError
from brace_drake.devices.motions.library import SafeMotion
from brace_drake.devices.motions.limits import check_reach
from brace_drake.link.device.limits import Limits
from brace_drake.link.operation.console import (
    CountDown,
    Keys,
    Say,
    describe_status,
)
from brace_drake.link.operation.journal import Journal, RunFile
from brace_drake.link.operation.motion import RING, place_motion
from brace_drake.link.operation.record import (
    SETTLE,
    RecordMotion,
    describe_device,
)
from brace_drake.link.operation.session import Session
from brace_drake.link.operation.station import (
    MakeControl,
    OpenDevice,
    moving_rings,
    recorded_as,
)
from brace_drake.link.protocol.messages import BAUD
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.brace import BraceScenario


class Recorder:
    """Records motions of one device into one campaign.

    Attributes:
        link: To the device, agreed.
        journal: Of the campaign.
    """

    def __init__(
        self,
        port: str,
        scenario: BenchScenario | BraceScenario,
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
        self._rings = moving_rings(scenario)
        self.link = OpenDevice(port, scenario, limits, baud, clear)
        try:
            rate = 1.0 / scenario.sensors.log_period
            device, stages = recorded_as(scenario)
            described = describe_device(self.link)
            self.journal = Journal(
                out, device, rate, subject, described, stages, SETTLE
            )
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
        """Counts down, then records.

        Args:
            motion: What to do, of one ring or placed.
            split: What for.
            countdown: s.
            keys: One of them stops.
            repeat_of: File that it repeats, "" for none; None: that of the
                same motion and split, where there is one.

        Raises:
            LimitsError: The motion reaches further than any may.
            StoppedError: The operator, the supervisor or the device stopped.
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

        def tell(share, session):
            Say(describe_status(share, session))

        try:
            run = RecordMotion(
                self.link, session, self.journal, motion, split,
                repeat_of or None, keys.pressed, tell,
            )  # fmt: skip
        except StoppedError:
            Say("stopped, the ring is released", end=True)
            raise
        finally:
            self.link.on_state = None
        Say(describe_status(1.0, session), end=True)
        return run

    def _Original(self, motion: SafeMotion, split: str) -> str | None:
        """The whole recording of a motion that another one repeats."""
        for item in self.journal.runs:
            same = item["file"] == f"{motion.name}.csv"
            if same and item["split"] == split and item.get("complete", True):
                return item["file"]
        return None
