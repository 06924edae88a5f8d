"""Runs of a plan, one after another, with the operator at hand."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from brace_drake.core.errors import StoppedError
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.link.operation.campaign_plan import PlannedRun
from brace_drake.link.operation.console import ReadKeys
from brace_drake.link.operation.recorder import Recorder


def WaitForOperator(what: str) -> None:
    """Asks for something and waits for Enter.

    Raises:
        StoppedError: There is nobody: standard input has ended.
    """
    print(f"{what}, then press Enter: ", end="", flush=True)
    if not sys.stdin.readline():
        raise StoppedError("not begun: nobody pressed Enter")


def RecordRuns(
    recorder: Recorder,
    runs: Sequence[tuple[int, PlannedRun]],
    total: int,
    countdown: int,
    ask: Callable[[str], None] = WaitForOperator,
) -> None:
    """Records runs; asks for the torso whenever it has to come or go.

    Args:
        recorder: Open.
        runs: To be recorded, with their numbers in the plan.
        total: Runs of the whole plan.
        countdown: Before each motion, s.
        ask: Called with what the operator is to do; returns when it is done.

    Raises:
        StoppedError: The operator, the supervisor or the device stopped; what
            had been recorded is in the campaign.
    """
    contact = None
    for number, planned in runs:
        motion = MakeMotion(planned.motion)
        if motion.contact != contact:
            contact = motion.contact
            ask("Put the torso in" if contact else "Take the torso out")
        print(
            f"run {number} of {total}: {planned.motion}"
            f" ({planned.split}), {motion.time[-1]:.0f} s",
            flush=True,
        )
        with ReadKeys() as keys:
            recorder.Record(
                motion,
                planned.split,
                countdown,
                keys,
                None if planned.repeat else "",
            )
