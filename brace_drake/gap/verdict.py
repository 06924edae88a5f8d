"""From fits and their null distribution to a verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.gap.candidates import CandidateFit
from brace_drake.gap.evaluation import Evaluator
from brace_drake.gap.surrogates import NullDistribution

# An explanation must take away this much of the gap's amplitude: nearly all
# where instruments and nominal numbers are given exactly, so that nothing else
# is left to differ; by far most on a real drive known by its recording alone.
MAJOR_KNOWN = 0.95
MAJOR_REAL = 0.75
# Root mean square, in floors, up to which a repaired twin counts as good: the
# noise itself is 1, what is left may not be more than the noise.
_NEAR_FLOOR = 1.0
_RESAMPLES = 2000


@dataclass(frozen=True)
class Verdict:
    """The answer.

    Attributes:
        gap: Whether there is one beyond noise and the subject's parameters.
        winner: The fit that explains it, or None.
        outside_library: A gap that nothing in the library explains.
        ambiguous_with: Rivals that the data cannot tell from the winner.
        probability: Share of resampled campaigns with the same answer.
    """

    gap: bool
    winner: CandidateFit | None
    outside_library: bool
    ambiguous_with: tuple[str, ...]
    probability: float


def misfit(evaluator: Evaluator, fit: CandidateFit) -> float:
    """Mean square above the floor's, in floors."""
    return fit.excess / evaluator.count


def gain(
    evaluator: Evaluator, nominal: CandidateFit, fit: CandidateFit
) -> float:
    """What a fit takes off the nominal fit's mean square."""
    return (nominal.excess - fit.excess) / evaluator.count


def closed_amplitude(
    evaluator: Evaluator, nominal: CandidateFit, fit: CandidateFit
) -> float:
    """Share of the gap's amplitude that a fit takes away, 1 at the floor."""
    before = np.sqrt(1.0 + max(0.0, misfit(evaluator, nominal))) - 1.0
    after = np.sqrt(1.0 + max(0.0, misfit(evaluator, fit))) - 1.0
    return float(1.0 - after / before) if before > 0.0 else 0.0


def has_gap(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fits: Sequence[CandidateFit],
    null: NullDistribution,
) -> bool:
    """Whether the nominal fit leaves more than its own noise would."""
    best = max((gain(evaluator, nominal, f) for f in fits), default=0.0)
    return bool(
        misfit(evaluator, nominal) > null.misfit_threshold
        or best > null.gain_threshold
    )


def smallest_share(evaluator: Evaluator) -> float:
    """Share of the gap's amplitude that an explanation must take away."""
    known = evaluator.twin.instruments_known
    return MAJOR_KNOWN if known else MAJOR_REAL


def explains(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fit: CandidateFit,
    null: NullDistribution,
) -> bool:
    """Whether a fit explains the gap: to the floor, or by far most of it.

    To the floor is what surrogates demand. A real machine has more than one
    flaw, so one effect may also leave a rest, if that is a small part of the
    gap; two effects together may not, for with so much freedom much of any
    gap can be covered.
    """
    if gain(evaluator, nominal, fit) <= null.gain_threshold:
        return False
    rest = misfit(evaluator, fit)
    if rest <= null.misfit_threshold:
        return True
    share = smallest_share(evaluator)
    major = closed_amplitude(evaluator, nominal, fit) >= share
    if len(fit.effects) > 1:
        return bool(major and rest <= _NEAR_FLOOR)
    return bool(major)


def decide(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fits: Sequence[CandidateFit],
    null: NullDistribution,
    seed: int,
) -> Verdict:
    """The verdict over the nominal fit and its rivals."""
    ranked = sorted(fits, key=lambda f: f.excess)
    if not has_gap(evaluator, nominal, ranked, null):
        stable = _same_answer(evaluator, nominal, ranked, None, null, seed)
        return Verdict(False, None, False, (), stable)
    good = [f for f in ranked if explains(evaluator, nominal, f, null)]
    if not good:
        stable = _same_answer(evaluator, nominal, ranked, None, null, seed)
        return Verdict(True, None, True, (), 1.0 - stable)
    # Fewer effects first: a pair is asked only where no single explains.
    fewest = min(len(f.effects) for f in good)
    good = [f for f in good if len(f.effects) == fewest]
    winner, others = good[0], good[1:]
    near = tuple(
        f.name
        for f in others
        if (f.excess - winner.excess) / evaluator.count < null.gain_threshold
    )
    same = _same_answer(evaluator, nominal, ranked, winner, null, seed)
    return Verdict(True, winner, False, near, same)


def _same_answer(evaluator, nominal, fits, winner, null, seed) -> float:
    """Share of campaigns, resampled by runs, with the same first answer."""
    candidates = [nominal, *fits]
    cost = np.array([f.excess_by_run for f in candidates])
    counts = np.array([p.count for p in evaluator.prepared], dtype=float)
    generator = np.random.default_rng([seed, 19])
    hits = 0
    for _ in range(_RESAMPLES):
        pick = generator.integers(len(counts), size=len(counts))
        total = cost[:, pick].sum(axis=1) / counts[pick].sum()
        best = int(np.argmin(total[1:])) + 1 if fits else 0
        if fits and total[0] - total[best] > null.gain_threshold:
            answer = candidates[best].name
        else:
            answer = "nominal"
        hits += answer == (winner.name if winner else "nominal")
    return (hits + 1.0) / (_RESAMPLES + 2.0)
