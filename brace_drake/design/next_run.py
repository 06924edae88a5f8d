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
from brace_drake.devices.motions.library import MotionSet, PlannedMotion
from brace_drake.devices.motions.reference import format_reference
from brace_drake.diagnose import Diagnosis
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.criterion import refined

FILE = "next_run.csv"

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


def choose_next_run(d: Diagnosis) -> NextRun | None:
    """The safe motion that separates a diagnosis' open causes best.

    None where nothing is open, or no motion of the device is known to be safe.
    """
    rivals = open_rivals(d)
    if len(rivals) < 2:
        return None
    twin, runs = d.device.twin, [p.run for p in d.evaluator.prepared]
    known = d.device.motions(twin, runs, d.campaign.rate_hz)
    if known is None:
        return None
    motions = [
        m
        for m in known.motions
        if all(_is_safe(twin, known, m, rival) for rival in rivals)
    ]
    if not motions:
        return None
    floors = {p.run.contact: p.floor for p in d.evaluator.prepared}
    seed = d.seed + _SEED
    prepared = planned_runs(
        twin, [m.run for m in motions], floors, known.rate, seed
    )
    return best_of(d.evaluator, motions, prepared, rivals)


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


def open_rivals(d: Diagnosis) -> list[Rival]:
    """What the next run should tell apart, the best explanation first.

    The winner and what is tied with it; without a winner, where the cause
    lies outside the library, the explanations that come nearest. Pairs of which
    one effect does as well are none.
    """
    best: dict[str, CandidateFit] = {}
    seen: set[frozenset[str]] = set()
    for fit in refined(d.fits):
        if d.criterion.part_as_good(fit, d.fits) is not None:
            continue
        if fit.is_scattered and fit.kinds not in seen:
            seen.add(fit.kinds)
            best["+".join(fit.identifiers)] = fit
    verdict = d.verdict
    if verdict.winner is not None and verdict.ambiguous_with:
        name = "+".join(verdict.winner.identifiers)
        tied = [n for n in verdict.ambiguous_with if n in best]
        fits = {name: verdict.winner, **{n: best[n] for n in tied}}
    elif verdict.outside_library:
        fits = dict(list(best.items())[:_NEAREST])
    else:
        fits = {}
    return [Rival(n, f.subject, f.uses) for n, f in fits.items()]


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


def describe_next(row: dict | None, found: NextRun | None) -> dict | None:
    """The document's `next_experiment`.

    Args:
        row: What is known without a safe motion: why, and a motion
            in words.
        found: From `choose_next_run`.
    """
    if row is None or found is None:
        return row
    motion, worst = found.motion, found.pairs[0]
    floors = np.sqrt(worst.separation)
    text = (
        f"{row['why']}; of the safe motions {motion.name}"
        f" ({motion.meaning}) separates best: {worst.first} and"
        f" {worst.second} would differ there by {floors:.0f} standard"
        " deviations of the noise"
    )
    return {
        "text": text,
        "why": row["why"],
        "motion": motion.name,
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
