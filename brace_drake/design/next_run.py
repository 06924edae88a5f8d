"""The run that would settle what a diagnosis leaves open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.core.output import WriteText
from brace_drake.design.planned import (
    effect_columns,
    planned_runs,
    predict,
    subject_columns,
)
from brace_drake.design.separation import (
    PairSeparation,
    choose_best,
    separate_pairs,
)
from brace_drake.devices.declaration import Device
from brace_drake.devices.motions.library import MotionSet, PlannedMotion
from brace_drake.devices.motions.reference import format_reference
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict
from brace_drake.selection.ranking import best_of_kinds

FILE = "next_run.csv"

# Deepest cause first: what lies upstream explains what follows.
_MOTIONS = {
    "actuation": "free_reversal: slow reversals of direction without contact,"
    " 2 mm/s, three times",
    "mechanism": "stairs: ten steps over the full stroke, 2 s each",
    "contact": "stairs with holds of 10 s at three depths",
    "torso": "quiet_hold of 15 s in contact, three times",
    "sensing": "quiet_hold of 10 s without contact, then a slow push",
}
# Explanations that come nearest, where none is good enough.
_NEAREST = 3
_SEED = 500


@dataclass(frozen=True)
class Rival:
    """An explanation: its name, subject, and effects as fitted."""

    name: str
    subject: np.ndarray
    uses: tuple[Use, ...]


@dataclass(frozen=True)
class NextRun:
    """The motion to run, and how far it would set rivals apart.

    Attributes:
        motion: Safe for the device.
        pairs: Least separated first.
    """

    motion: PlannedMotion
    pairs: tuple[PairSeparation, ...]

    @property
    def separation(self) -> float:
        """Of the worst pair, squares of the noise floor."""
        return self.pairs[0].separation


def choose_next_run(
    device: Device,
    evaluator: Evaluator,
    criterion: Criterion,
    fits: Sequence[CandidateFit],
    verdict: Verdict,
    seed: int,
) -> NextRun | None:
    """The safe motion that separates the causes best that are left open.

    Args:
        device: That is to run it.
        evaluator: Over the fit runs.
        criterion, fits, verdict: Of the search and its decision.
        seed: Of the diagnosis.

    Returns:
        None where nothing is open, or no motion of the device is known to be
        safe.
    """
    rivals = open_rivals(criterion, fits, verdict)
    if len(rivals) < 2:
        return None
    twin, runs = device.twin, [p.run for p in evaluator.prepared]
    known = device.motions(runs)
    if known is None:
        return None
    motions = [
        m
        for m in known.motions
        if all(_is_safe(twin, known, m, rival) for rival in rivals)
    ]
    if not motions:
        return None
    floors = {p.run.contact: p.floor for p in evaluator.prepared}
    prepared = planned_runs(
        twin, [m.run for m in motions], floors, known.rate, seed + _SEED
    )
    return best_of(evaluator, motions, prepared, rivals)


def best_of(
    evaluator: Evaluator,
    motions: Sequence[PlannedMotion],
    prepared: Sequence[PreparedRun],
    rivals: Sequence[Rival],
) -> NextRun | None:
    """The best of planned runs, by the predictions of the evaluator's twin."""
    planned = Evaluator(evaluator.twin, prepared, evaluator.jobs)
    points = [(r.subject, r.uses) for r in rivals]
    predictions = predict(planned, points)
    # Dry friction hardly changes what the subject does, but costs dithers.
    smooth = [(e, v) for e, v in rivals[0].uses if not e.dithered]
    columns = subject_columns(planned, rivals[0].subject, smooth)
    own = [effect_columns(planned, r.subject, r.uses) for r in rivals]
    separations, by_name = {}, {}
    for i, motion in enumerate(motions):
        foreseen = [p[i] for p in predictions]
        free = [c[i] for c in own]
        if any(a is None for a in (*foreseen, *free, columns[i])):
            continue
        names = [r.name for r in rivals]
        separations[motion.name] = separate_pairs(
            dict(zip(names, foreseen, strict=True)),
            columns[i],
            dict(zip(names, free, strict=True)),
        )
        by_name[motion.name] = motion
    best = choose_best(separations)
    if best is None:
        return None
    return NextRun(by_name[best], tuple(separations[best]))


def open_rivals(
    criterion: Criterion, fits: Sequence[CandidateFit], verdict: Verdict
) -> list[Rival]:
    """What the next run should tell apart, the best explanation first.

    The winner and what is tied with it; without a winner, where the cause
    lies outside the library, the explanations that come nearest.
    """
    if not (verdict.ambiguous_with or verdict.outside_library):
        return []
    # What is within tolerances is no explanation.
    best = {
        "+".join(e.cause for e in criterion.findings(fit)): fit
        for fit in best_of_kinds(criterion, fits)
        if criterion.findings(fit)
    }
    chosen = dict(list(best.items())[:_NEAREST])
    if verdict.winner is not None and verdict.ambiguous_with:
        name = "+".join(verdict.effects)
        tied = [n for n in verdict.ambiguous_with if n in best]
        chosen = {name: verdict.winner, **{n: best[n] for n in tied}}
    return [Rival(n, f.subject, f.uses) for n, f in chosen.items()]


def _is_safe(
    twin, known: MotionSet, motion: PlannedMotion, rival: Rival
) -> bool:
    uses = [(e, e.in_run(v[: len(e.parameters)], 0)) for e, v in rival.uses]
    subject = rival.subject
    try:
        log = twin.coarse().simulate(twin.motion(motion.run), subject, uses)
    except BraceError:
        return False
    return known.exceeded(twin, motion, subject, log) is None


def describe_next(
    verdict: Verdict, blocks: Sequence[str], found: NextRun | None
) -> dict | None:
    """What would settle what is open; None where nothing is.

    Args:
        verdict: Of the diagnosis.
        blocks: In which the gap lies.
        found: From `choose_next_run`; without one a motion in words is told.
    """
    if verdict.winner is not None and verdict.ambiguous_with:
        first, *_ = verdict.effects
        names = [*verdict.effects, *verdict.ambiguous_with]
        why = "these data do not separate " + ", ".join(names)
        motion = next(
            e.experiment for e in verdict.winner.effects if e.cause == first
        )
    elif verdict.outside_library and blocks:
        why = f"the largest unexplained rest lies in {blocks[0]}"
        motion = _MOTIONS.get(blocks[0], "repeat the runs at half speed")
    else:
        return None
    if found is None:
        return {"why": why, "motion": motion}
    worst = found.pairs[0]
    floors = np.sqrt(worst.separation)
    text = (
        f"{why}; of the safe motions {found.motion.name}"
        f" ({found.motion.meaning}) separates best: {worst.first} and"
        f" {worst.second} would differ there by {floors:.0f} standard"
        " deviations of the noise"
    )
    return {
        "text": text,
        "why": why,
        "motion": found.motion.name,
        "file": FILE,
        "separation": found.separation,
        "pairs": [
            {"effects": [p.first, p.second], "separation": p.separation}
            for p in found.pairs
        ],
    }


def WriteNextRun(found: NextRun | None, folder: Path) -> Path | None:
    """Writes next_run.csv, the reference to run; else removes an older one.

    Raises:
        OutputError: It cannot be written.
    """
    path = folder / FILE
    if found is None:
        path.unlink(missing_ok=True)
        return None
    WriteText(path, format_reference(found.motion.run, found.motion.columns))
    return path
