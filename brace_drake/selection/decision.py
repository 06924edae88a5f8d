"""From fits and their null distribution to a verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from brace_drake.identification.evaluation import Evaluator, is_dithered, sticks
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.acceptance import (
    is_near_enough,
    largest_rest,
    smallest_share,
)
from brace_drake.selection.measures import (
    EXACT_TO,
    closed_amplitude,
    closes_half,
    gains,
    is_flexible,
    left_over,
    misfit,
)
from brace_drake.selection.null_bootstrap import NOISE_TRUST, NullDistribution
from brace_drake.selection.probability import (
    sure_of_effects,
    sure_of_no_gap,
    sure_of_outside,
    with_less_known,
)

# Where drives stick replays come to no floor: up to here what is left is no
# sign of another effect.
_NEAR_FLOOR_ROUGH = 0.5
# Two effects have to leave this share of what one leaves, the noise's level
# being right.
_SECOND_PAYS = 0.25
# What errors of the twin itself leave; an average over noise is no nearer than
# the above.
_ERRORS = 0.005
# A threshold of misfit that campaigns recorded in full stay below.
_WHOLE_THRESHOLD = 0.125
# One that leaves so many times the least that two have to be preferred to is a
# rival that leaves as much as they do.
_PREFERRED = 2.0
# Rivals that leave less than this many times the winner's rest are tied.
_TIED = 1.5


@dataclass(frozen=True)
class Verdict:
    """The answer.

    Attributes:
        gap: Whether there is one beyond noise and the subject's parameters.
        winner: The fit that explains it, or None.
        outside_library: A gap that nothing in the library explains.
        ambiguous_with: Rivals that the data cannot tell from the winner.
        probability: That the answer is right, see `gap.probability`.
    """

    gap: bool
    winner: CandidateFit | None
    outside_library: bool
    ambiguous_with: tuple[str, ...]
    probability: float


def part_as_good(
    evaluator: Evaluator,
    fit: CandidateFit,
    fits: Sequence[CandidateFit],
    null: NullDistribution,
) -> CandidateFit | None:
    """Some of a fit's effects that leave no more without the others, but for
    what noise would gain; None where all are needed.
    """
    for part in refined(fits):
        if not part.kinds < fit.kinds:
            continue
        if not gains(evaluator, part, fit, null):
            return part
    return None


def has_gap(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fits: Sequence[CandidateFit],
    null: NullDistribution,
) -> bool:
    """Whether the nominal fit leaves more than its own noise would."""
    return misfit(evaluator, nominal) > null.misfit_threshold or any(
        gains(evaluator, nominal, f, null) for f in refined(fits)
    )


def refined(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Fits whose search was led to its end, best first."""
    return sorted((f for f in fits if f.refined), key=lambda f: f.excess)


def plausible(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Those of the refined fits whose many parameters may be a draw."""
    return [f for f in refined(fits) if f.is_scattered]


def explains(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fit: CandidateFit,
    null: NullDistribution,
) -> bool:
    """Whether a fit explains the gap: to the floor, as surrogates demand, or
    by far most of it; and not by an effect whose many parameters are no draw.
    """
    if not gains(evaluator, nominal, fit, null):
        return False
    rest = misfit(evaluator, fit)
    is_rough = sticks(evaluator.twin, fit.uses)
    most = largest_rest(evaluator, nominal, len(fit.effects), is_rough)
    little = rest <= max(null.misfit_threshold, most)
    return bool(little) and fit.is_scattered


def decide(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fits: Sequence[CandidateFit],
    null: NullDistribution,
    is_chance: Callable[[CandidateFit], bool] = lambda fit: False,
    shown: frozenset[str] = frozenset(),
) -> Verdict:
    """The verdict over the nominal fit and its rivals.

    Args:
        evaluator, nominal, fits, null: Of the search; those refined may win.
        is_chance: Whether a fit takes no more than its freedom would; it
            explains nothing then.
        shown: Effects that a part of the machine shows by itself, which an
            explanation has to have, if one that has them explains.
    """
    ranked = refined(fits)
    if not has_gap(evaluator, nominal, ranked, null):
        rest = max(0.0, misfit(evaluator, nominal)) / null.misfit_threshold
        sure = sure_of_no_gap(rest)
        # Below a higher threshold more may hide.
        known = min(1.0, _WHOLE_THRESHOLD / null.misfit_threshold)
        sure = with_less_known(sure, known * evaluator.recorded)
        return Verdict(False, None, False, (), sure)
    good = [
        f
        for f in ranked
        if explains(evaluator, nominal, f, null) and not is_chance(f)
    ]
    good = [f for f in good if shown <= f.kinds] or good
    if not good:
        best = max(
            (
                closed_amplitude(evaluator, nominal, f)
                for f in plausible(ranked)
            ),
            default=0.0,
        )
        short = best / smallest_share(evaluator)
        sure = with_less_known(sure_of_outside(short), evaluator.recorded)
        return Verdict(True, None, True, (), sure)
    winner = simplest_of_fewest(evaluator, good, null)
    number = len(winner.effects)
    rivals = [
        f
        for f in fits
        if f.kinds != winner.kinds
        and len(f.effects) in ((1, number) if is_flexible(f) else (number,))
        and (f.is_scattered or not f.refined)
    ]
    times_left = partial(_times_left, evaluator, winner)
    near = {
        f.kinds: "+".join(f.identifiers)
        for f in sorted(rivals, key=lambda f: -f.excess)
        if times_left(f) < _TIED
        # Of dozens of parameters only the end of a search tells.
        and (f.refined or not is_flexible(f))
    }
    contrasts = [times_left(f) for f in rivals]
    if number > 1:
        # One that two were preferred to by little might be all there is.
        ones = [f for f in good if len(f.effects) == 1]
        contrasts += [_PREFERRED * _SECOND_PAYS * times_left(f) for f in ones]
    contrast = min(contrasts, default=np.inf)
    rest = 0.0
    if misfit(evaluator, winner) > null.misfit_threshold:
        rest = 1.0 - closed_amplitude(evaluator, nominal, winner)
    sure = sure_of_effects(contrast, rest, number)
    sure = with_less_known(sure, evaluator.recorded)
    return Verdict(True, winner, False, tuple(reversed(near.values())), sure)


def is_near_floor(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fits: Sequence[CandidateFit],
    limit: float,
) -> bool:
    """Whether the best of fits leaves at most so many floors, mean square.

    Or a bit more, where it closes much of the gap and can follow a recording
    no nearer.
    """
    best = next(iter(plausible(fits)), None)
    if best is None:
        return False
    if sticks(evaluator.twin, best.uses):
        # Friction that the twin carries has taken its part before.
        carried = sticks(evaluator.twin, ())
        if carried or closes_half(evaluator, nominal, best):
            limit = max(limit, _NEAR_FLOOR_ROUGH)
    return misfit(evaluator, best) <= limit


def simplest_of_fewest(
    evaluator: Evaluator,
    fits: Sequence[CandidateFit],
    null: NullDistribution,
) -> CandidateFit:
    """The simplest fit of one effect, or of two where the second one pays.

    It does where two leave less than a quarter of what one leaves, both less
    what the level of the noise may be off, and gain more than noise would.
    Beside one of dozens of parameters, which can cover much of any gap, two of
    few need only leave less, or as little as any twin is exact to.
    """
    by_number: dict[int, list[CandidateFit]] = {}
    for fit in fits:
        by_number.setdefault(len(fit.effects), []).append(fit)
    numbers = sorted(by_number)
    best = simplest(evaluator, by_number[numbers[0]])
    for number in numbers[1:]:
        richer = simplest(evaluator, by_number[number])
        is_less = is_flexible(best) and not is_flexible(richer)
        pays = 1.0 if is_less else _SECOND_PAYS
        does_gain = gains(evaluator, best, richer, null)
        errors = max(_errors(evaluator, f) for f in (best, richer))
        off = _level_off(evaluator, richer)
        if is_less:
            off = max(0.0, off)
        rest = misfit(evaluator, richer)
        left = rest - off + errors
        is_little = left < pays * (misfit(evaluator, best) - off + errors)
        is_little |= is_less and rest <= EXACT_TO
        is_near = is_near_enough(evaluator, richer)
        if is_little and (does_gain or is_less) and is_near:
            best = richer
    return best


def _level_off(evaluator: Evaluator, fit: CandidateFit) -> float:
    """What the noise's level may be off if a fit is right, for all fits."""
    return float(np.clip(misfit(evaluator, fit), -NOISE_TRUST, NOISE_TRUST))


def _errors(evaluator: Evaluator, fit: CandidateFit) -> float:
    """Mean square that errors of the twin itself leave a fit."""
    twin = evaluator.twin
    is_exact = twin.instruments_known and not is_dithered(twin, fit.uses)
    return _ERRORS if is_exact else EXACT_TO


def _times_left(
    evaluator: Evaluator, winner: CandidateFit, fit: CandidateFit
) -> float:
    """What a fit leaves, in terms of what the winner leaves.

    Where that is two effects, whose second one may take less than the noise's
    level may be off, what this may be is taken from both; not beside dozens of
    parameters, which can take as much.
    """
    if len(winner.effects) == 1 or is_flexible(fit):
        return left_over(evaluator, fit) / left_over(evaluator, winner)
    errors = max(_errors(evaluator, f) for f in (winner, fit))
    off = _level_off(evaluator, winner) - errors
    return max(errors, misfit(evaluator, fit) - off) / (
        misfit(evaluator, winner) - off
    )


def simplest(
    evaluator: Evaluator, fits: Sequence[CandidateFit]
) -> CandidateFit:
    """The fit of fewest parameters among those that leave about the least.

    A richer one has to leave less than half of what a simpler one leaves.
    """
    least = min(left_over(evaluator, f) for f in fits)
    near = [f for f in fits if left_over(evaluator, f) <= 2.0 * least]
    return min(near, key=lambda f: (f.freedom, f.excess))
