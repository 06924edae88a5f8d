"""Runs of a campaign: which it needs, and one after another on a device."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from brace_drake.core.errors import (
    CampaignError,
    StoppedError,
    quoted,
    suggest,
)
from brace_drake.core.reading import LoadYaml
from brace_drake.devices.motions.library import MOTIONS, MakeMotion
from brace_drake.link.operation.console import ReadKeys
from brace_drake.link.operation.recorder import Recorder
from brace_drake.recording.fields import SWITCH, TEXT, WHAT_FOR, take

FORMAT = "brace-plan/1"
_RUN = {
    "motion": TEXT._replace(required=True),
    "split": WHAT_FOR,
    "repeat": SWITCH,
}


@dataclass(frozen=True)
class PlannedRun:
    """A run to be recorded: motion, split, whether it repeats one before."""

    motion: str
    split: str = "fit"
    repeat: bool = False


# Free runs first, as the torso then comes only once. Repeats tell the noise;
# validation runs move as no fit run does.
STANDARD_PLAN = (
    PlannedRun("free_multisine"),
    PlannedRun("free_reversal"),
    PlannedRun("free_reversal_fast", "validation"),
    PlannedRun("quiet_hold"),
    PlannedRun("push"),
    PlannedRun("push", repeat=True),
    PlannedRun("stairs"),
    PlannedRun("reversal"),
    PlannedRun("multisine"),
    PlannedRun("push_fast", "validation"),
    PlannedRun("stairs_both_sides", "validation"),
    PlannedRun("multisine_fast", "validation"),
)


def LoadPlan(path: str | Path | None) -> tuple[PlannedRun, ...]:
    """A plan from a file; the standard one where there is none.

    The file is YAML: `format: brace-plan/1` and `runs`, a list of items with
    `motion` and, where needed, `split: validation` and `repeat: true`; or the
    plan.json of `brace-drake plan`, whose runs are motions alone.

    Raises:
        CampaignError: One line: file, run, key, value, what is allowed.
    """
    if path is None:
        return STANDARD_PLAN
    content = LoadYaml(path, CampaignError)
    if content.get("format") != FORMAT:
        raise CampaignError(f"{path}: format must be {FORMAT!r}")
    runs = content.get("runs")
    if not isinstance(runs, list) or not runs:
        raise CampaignError(f"{path}: runs must be a list of runs")
    return tuple(
        _parse_run(run, f"{path}: run {i}") for i, run in enumerate(runs, 1)
    )


def _parse_run(run: object, place: str) -> PlannedRun:
    if isinstance(run, str):
        run = {"motion": run}
    run = run if isinstance(run, dict) else {}
    for key in run:
        if key not in _RUN:
            hint = suggest(key, _RUN)
            raise CampaignError(f"{place}: no key {quoted(key)}{hint}")
    values, faults = take(run, _RUN)
    for name, wanted, value in faults:
        if value is None:
            raise CampaignError(f"{place} has no {name}")
        raise CampaignError(
            f"{place}: {name} is {quoted(value)}; allowed: {wanted}"
        )
    if values["motion"] not in MOTIONS:
        MakeMotion(values["motion"])
    return PlannedRun(**values)


def remaining_runs(
    plan: tuple[PlannedRun, ...], recorded: list[dict]
) -> list[tuple[int, PlannedRun]]:
    """What of a plan is still to be recorded, with numbers from 1.

    Args:
        plan: Of the whole campaign.
        recorded: Items of campaign.yaml so far; those that are not complete do
            not count.
    """
    have: dict[tuple[str, str], int] = {}
    for item in recorded:
        if item.get("complete", True):
            name = Path(item["file"]).stem
            name = name if name in MOTIONS else name.rpartition("_")[0]
            key = (name, item["split"])
            have[key] = have.get(key, 0) + 1
    left = []
    for number, run in enumerate(plan, 1):
        key = (run.motion, run.split)
        if have.get(key, 0) > 0:
            have[key] -= 1
        else:
            left.append((number, run))
    return left


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
