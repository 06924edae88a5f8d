"""The verdict: is there a gap, which effects explain it, how sure is that."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, plausible, refined


@dataclass(frozen=True)
class Verdict:
    """The answer.

    Attributes:
        gap: Whether there is one beyond noise and the subject's parameters.
        winner: The fit that explains it, or None.
        outside_library: A gap that nothing in the library explains.
        ambiguous_with: Rivals that the data cannot tell from the winner.
        probability: That the answer is right, see `sure_of_effects`.
    """

    gap: bool
    winner: CandidateFit | None
    outside_library: bool
    ambiguous_with: tuple[str, ...]
    probability: float


def decide(
    criterion: Criterion,
    fits: Sequence[CandidateFit],
    is_chance: Callable[[CandidateFit], bool] = lambda fit: False,
    shown: frozenset[str] = frozenset(),
) -> Verdict:
    """The verdict over the nominal fit and its rivals.

    Args:
        criterion: Of the campaign, with its null distribution.
        fits: Of the search; those refined may win.
        is_chance: Whether a fit takes no more than its freedom would; it
            explains nothing then.
        shown: Effects that a part of the machine shows by itself, which an
            explanation has to have, if one that has them explains.
    """
    ranked = refined(fits)
    if not criterion.has_gap(ranked):
        return Verdict(False, None, False, (), _sure_of_no_gap(criterion))
    good = [f for f in ranked if criterion.explains(f) and not is_chance(f)]
    good = [f for f in good if shown <= f.kinds] or good
    if not good:
        closed = [criterion.closed(f) for f in plausible(ranked)]
        short = max(closed, default=0.0) / criterion.least_share
        sure = with_less_known(sure_of_outside(short), criterion.recorded)
        return Verdict(True, None, True, (), sure)
    winner = _simplest_of_fewest(criterion, good)
    rivals = _rivals(criterion, winner, fits)
    tied = {
        f.kinds: "+".join(f.identifiers)
        for f in sorted(rivals, key=lambda f: -f.excess)
        if _times_left(criterion, winner, f) < thresholds.TIED
        # Of dozens of parameters only the end of a search tells.
        and (f.refined or not f.is_flexible)
    }
    sure = _sure_of_winner(criterion, winner, rivals, good)
    return Verdict(True, winner, False, tuple(reversed(tied.values())), sure)


def _rivals(criterion, winner, fits) -> list[CandidateFit]:
    """Other effects, as many of them; one of dozens of parameters too.

    A richer form of the winner that gains nothing by its freedom is the same
    model and no rival.
    """
    number = len(winner.effects)
    return [
        f
        for f in fits
        if f.kinds != winner.kinds
        and len(f.effects) in ((1, number) if f.is_flexible else (number,))
        and (f.is_scattered or not f.refined)
        and not (_holds(f, winner) and not criterion.gains(f, winner))
    ]


def _holds(rich: CandidateFit, special: CandidateFit) -> bool:
    """Whether each effect of one fit is one of another's, or a special case
    of it.
    """
    return len(rich.effects) == len(special.effects) and all(
        any(r.name == s.name or r.is_richer_than(s) for r in rich.effects)
        for s in special.effects
    )


def _sure_of_no_gap(criterion: Criterion) -> float:
    limit = criterion.null.misfit_threshold
    rest = max(0.0, criterion.misfit(criterion.nominal)) / limit
    # Below a higher threshold more may hide.
    known = min(1.0, thresholds.WHOLE_THRESHOLD / limit)
    return with_less_known(sure_of_no_gap(rest), known * criterion.recorded)


def _sure_of_winner(criterion, winner, rivals, good) -> float:
    number = len(winner.effects)
    contrasts = [_times_left(criterion, winner, f) for f in rivals]
    if number > 1:
        # One that two were preferred to by little might be all there is: one
        # that leaves just what two are preferred to leaves as much as they do.
        least = thresholds.SIMPLER * thresholds.SECOND_PAYS
        contrasts += [
            least * _times_left(criterion, winner, f)
            for f in good
            if len(f.effects) == 1
        ]
    rest = 0.0
    if criterion.misfit(winner) > criterion.null.misfit_threshold:
        rest = 1.0 - criterion.closed(winner)
    sure = sure_of_effects(min(contrasts, default=np.inf), rest, number)
    return with_less_known(sure, criterion.recorded)


def _simplest_of_fewest(
    criterion: Criterion, fits: Sequence[CandidateFit]
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
    first, *others = sorted(by_number)
    best = _simplest(criterion, by_number[first])
    for number in others:
        more = _simplest(criterion, by_number[number])
        if _pays(criterion, best, more):
            best = more
    return best


def _pays(criterion: Criterion, one: CandidateFit, two: CandidateFit) -> bool:
    """Whether more effects are worth it."""
    if not (
        criterion.is_known or criterion.misfit(two) <= thresholds.NEAR_FLOOR
    ):
        return False
    is_less = one.is_flexible and not two.is_flexible
    share = 1.0 if is_less else thresholds.SECOND_PAYS
    errors = max(_errors(criterion, f) for f in (one, two))
    off = _level_off(criterion, two)
    if is_less:
        off = max(0.0, off)
    left = criterion.misfit(two) - off + errors
    is_little = left < share * (criterion.misfit(one) - off + errors)
    is_little |= is_less and criterion.misfit(two) <= thresholds.TWIN_ERROR
    return is_little and (is_less or criterion.gains(two, one))


def _simplest(
    criterion: Criterion, fits: Sequence[CandidateFit]
) -> CandidateFit:
    """The fit of fewest parameters among those that leave about the least."""
    least = thresholds.SIMPLER * min(criterion.left(f) for f in fits)
    near = [f for f in fits if criterion.left(f) <= least]
    return min(near, key=lambda f: (f.freedom, f.excess))


def _level_off(criterion: Criterion, fit: CandidateFit) -> float:
    """What the noise's level may be off if a fit is right, for all fits."""
    level = thresholds.NOISE_LEVEL
    return float(np.clip(criterion.misfit(fit), -level, level))


def _errors(criterion: Criterion, fit: CandidateFit) -> float:
    """Mean square that errors of the twin itself leave a fit."""
    if criterion.is_known and not fit.is_dithered:
        return thresholds.TWIN_ERROR_EXACT
    return thresholds.TWIN_ERROR


def _times_left(
    criterion: Criterion, winner: CandidateFit, fit: CandidateFit
) -> float:
    """What a fit leaves, in terms of what the winner leaves.

    Where that is two effects, whose second one may take less than the noise's
    level may be off, what this may be is taken from both; not beside dozens of
    parameters, which can take as much.
    """
    if len(winner.effects) == 1 or fit.is_flexible:
        return criterion.left(fit) / criterion.left(winner)
    errors = max(_errors(criterion, f) for f in (winner, fit))
    off = _level_off(criterion, winner) - errors
    left = max(errors, criterion.misfit(fit) - off)
    return left / (criterion.misfit(winner) - off)


def _logistic(x: float) -> float:
    return min(
        max(1.0 / (1.0 + math.exp(-x)), thresholds.LEAST_PROBABILITY),
        thresholds.MOST_PROBABILITY,
    )


def _calibrated(p: float) -> float:
    """A probability with the log-odds that withheld cases have shown."""
    odds = math.log(p / (1.0 - p))
    return _logistic(thresholds.ODDS_OFFSET + thresholds.ODDS_SLOPE * odds)


def sure_of_effects(contrast: float, rest: float, count: int) -> float:
    """Probability that the named effects are right, and all there are.

    Args:
        contrast: What the best rival leaves over what the winner leaves.
        rest: Share of the gap's amplitude that the winner leaves; in it
            another effect may hide.
        count: Number of effects named.
    """
    slope = 2.0 if count == 1 else 1.5
    right = _logistic(slope * math.log(max(contrast, 1e-3)) - 0.5)
    whole = _logistic(3.0 - 10.0 * max(rest, 0.0))
    return _calibrated(max(right * whole, thresholds.LEAST_PROBABILITY))


def sure_of_no_gap(rest: float) -> float:
    """Probability that there is no gap; `rest` in units of the threshold."""
    return _calibrated(_logistic(4.0 * (1.0 - rest)))


def with_less_known(probability: float, known: float) -> float:
    """A probability drawn towards one half.

    Args:
        probability: With all that a campaign records.
        known: Share of that which is known.
    """
    return min(probability, 0.5 + (probability - 0.5) * known)


def sure_of_outside(short: float) -> float:
    """Probability that nothing in the library explains the gap.

    Args:
        short: Best explained share of what is asked for.
    """
    return _calibrated(_logistic(6.0 * (1.0 - short) + 0.5))
