"""The shortlist after screening, and the end of its searches."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import partial

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_effects
from brace_drake.identification.held_out import check_fit
from brace_drake.identification.numbers.reweigh import noise_left, reweigh
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, cost_of, refined
from brace_drake.selection.search.candidate import Candidate, make_candidate
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.tolerated import left_by


def best_fits(candidates: Sequence[Candidate]) -> list[CandidateFit]:
    """The best fit of each set of effects; searched before predicted ones."""
    fits = [c.fit() for c in sorted(candidates, key=lambda c: c.left)]
    searched = {f.name for f in fits if f.is_searched}
    best: dict[str, CandidateFit] = {}
    for fit in fits:
        if fit.name not in searched or fit.is_searched:
            best.setdefault(fit.name, fit)
    return list(best.values())


def refine(
    evaluator: Evaluator,
    fits: Sequence[CandidateFit],
    remaining: float,
) -> list[CandidateFit]:
    """Leads the searches of the shortlist to their end.

    Args:
        evaluator: Over the fit runs.
        fits: From screening.
        remaining: Excess of the fit that screening set out from, strained;
            what takes next to nothing of it is not listed, unless it is the
            best.

    Returns:
        All fits in the order of what screening left, those listed refined.
    """
    count = evaluator.count

    def left(fit):
        return left_by(fit, count)

    ranked = sorted(fits, key=left)
    if not ranked:
        return []
    # Rivals are compared as screening has left them, all alike unfinished.
    trust = thresholds.SHORTLIST_TRUST * count
    near = thresholds.SHORTLIST * max(trust, left(ranked[0]) + trust)
    bar = min(thresholds.GAINED * remaining - trust, near)
    listed = [
        i
        for i, fit in enumerate(ranked[: thresholds.NUM_SHORTLIST])
        if fit.is_searched and not fit.refined and (i == 0 or left(fit) <= bar)
    ]
    tasks = [partial(try_refine, evaluator, ranked[i]) for i in listed]
    known = evaluator.tolerances
    if known is None or known.noise == 1.0:
        ends = evaluator.together(tasks)
    else:
        # Each has the tolerances weighed beside what it leaves.
        ends = [task() for task in tasks]
    for i, end in zip(listed, ends, strict=True):
        ranked[i] = end
    return ranked


def weighed_alike(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """A fit where it stands, with tolerances weighed as the evaluator has
    them.
    """
    here, there = evaluator.tolerances, fit.tolerances
    if here is None or there is None or here.noise == there.noise:
        return fit
    return reweigh(evaluator, fit, here.noise)


def try_refine(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """Leads a search to its end; the fit as it is where its twin breaks.

    It begins with tolerances weighed as the evaluator has them. Where that is
    beside what another fit has left along them, they are then weighed beside
    what this one does.
    """
    known, fit = evaluator.tolerances, weighed_alike(evaluator, fit)
    try:
        fit = fit_effects(evaluator, fit.effects, fit, is_compared=True)
        for _ in range(thresholds.REWEIGHED):
            if fit.tolerances is None or fit.tolerances.noise == 1.0:
                break
            noise = noise_left(evaluator, fit)
            if noise > thresholds.QUIETER * fit.tolerances.noise:
                break
            fit = reweigh(evaluator, fit, noise)
            evaluator.tolerances = known.beside_noise(noise)
            fit = fit_effects(evaluator, fit.effects, fit, is_compared=True)
    except (BraceError, ValueError):
        # A candidate whose twin cannot even run explains nothing.
        return fit
    finally:
        evaluator.tolerances = known
    return check_fit(evaluator, fit)


def rivals(
    criterion: Criterion,
    base: CandidateFit,
    best: CandidateFit,
    fits: Sequence[CandidateFit],
) -> list[int]:
    """Places of the fits that are to be led on, best first: of each set of
    effects that is named the best, where the cost of one effect would set it
    apart from the best of all.

    Args:
        criterion: Of the search.
        base: That the fits have one effect more than.
        best: Of all so far.
        fits: Of one round.
    """
    least = criterion.score(best)
    ended = [(criterion.score(f), i) for i, f in enumerate(fits) if f.refined]
    found: dict[frozenset[str], int] = {}
    for score, i in sorted(ended):
        named = criterion.named(fits[i])
        # What names nothing more than the base is no rival, but may be best.
        is_other = named != criterion.named(base) or fits[i] is best
        if is_other and score <= least + cost_of(1):
            found.setdefault(named, i)
    few = list(found.values())[: thresholds.NUM_SHORTLIST]
    return [i for i in few if not fits[i].is_settled]


def improve_choices(
    base: Linearisation, fits: list[CandidateFit]
) -> list[CandidateFit]:
    """Tries other forms and discrete parameters of the best fit's last effect,
    where it has any: they go on from where that one has come.
    """
    best = next(iter(refined(fits)), None)
    if best is None or best.effects[-1].is_flexible:
        return fits
    if best.excess / base.evaluator.count <= thresholds.TWIN_ERROR:
        return fits
    for candidate in other_choices(base, best):
        other = candidate.fit()
        if other.is_searched and other.excess < best.excess:
            other = try_refine(base.evaluator, other)
        if other.refined and other.excess < best.excess:
            fits = [other if f is best else f for f in fits]
            best = other
    return fits


def other_choices(base: Linearisation, fit: CandidateFit) -> list[Candidate]:
    """The fit with its last effect in other forms, and with discrete parameters
    at other values.
    """
    effect, found = fit.effects[-1], []
    mine = fit.values[-1][: len(effect.parameters)]
    discrete = [p.choices for p in effect.parameters if p.choices]
    others = _other_forms(base.evaluator.effects, effect)
    kept = fit.effects[:-1]
    able = [o for o in others if not any(o.is_alike(e) for e in kept)]
    forms = [effect, *able]
    for form, choice in itertools.product(forms, itertools.product(*discrete)):
        values = mine.copy()
        values[~effect.is_continuous] = choice
        if form is effect and np.array_equal(values, mine):
            continue
        candidate = make_candidate(
            base,
            [*fit.effects[:-1], form],
            [*fit.values[:-1], values],
            fit.subject,
        )
        if candidate is not None:
            found.append(candidate)
    found.sort(key=lambda c: c.residual @ c.residual)
    for candidate in found[: thresholds.OTHER_CHOICES]:
        # Where drives stick, sensitivities of the base are none of it.
        candidate.step(base, thresholds.CHOICE_STEPS, own=effect.dithered)
    return found[: thresholds.OTHER_CHOICES]


def _other_forms(effects: Sequence[Effect], effect: Effect) -> list[Effect]:
    """Forms of an effect, here and elsewhere, with the same parameters."""
    names = [p.name for p in effect.parameters]
    return [
        other
        for other in effects
        if other.name == effect.name
        and other.variant != effect.variant
        and [p.name for p in other.parameters] == names
    ]
