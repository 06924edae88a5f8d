"""Dry friction within its tolerance, as an effect.

Other numbers act on a straight line within their tolerances; drives that stick
a little do not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.stack import behind_joints
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.held_out import estimate_off
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.level import tolerated_friction
from brace_drake.selection.search.candidate import (
    Candidate,
    best_of_starts,
    candidate_of,
    with_one_more,
)
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.shortlist import other_choices
from brace_drake.selection.search.within import refit_within


def fit_friction(
    lines: Linearisation, criterion: Criterion, effects: Sequence[Effect]
) -> list[CandidateFit]:
    """A fit with dry friction that a tolerance allows for, in the form that
    begins best and in others from where that one ends, where something is
    left; refined.

    Args:
        lines: At the fit that is looked at.
        criterion: Of the campaign.
        effects: Those that may be added.
    """
    behind, beside = [], []
    power = tolerated_friction(lines.evaluator, lines.base, np.inf)
    if power < thresholds.WORTH_FRICTION * criterion.misfit(lines.base):
        return []
    for nuisance, t in estimate_off(lines.evaluator, lines.base):
        ((card, values),) = nuisance.uses
        if not card.dithered:
            continue
        start = np.minimum(values * max(t, 1.0), card.upper)
        forms = [e for e in effects if e.name == card.name]
        # Behind a joint that gives way it takes of what is left once it has
        # tolerances as they act there.
        best = _stepped(lines, _behind_joints(lines, card, start))
        behind += [] if best is None else [best.fit()]
        begun = [with_one_more(lines, form, start) for form in forms]
        best = _stepped(lines, begun)
        if best is None:
            continue
        begun = [best, *other_choices(lines, best.fit())]
        # It takes of what is left, not of what tolerances are stretched to.
        fits = [c.fit() for c in begun]
        beside += [f for f in fits if f.excess < lines.excess]
    most = least = min((f.excess for f in beside), default=0.0)
    tolerances = lines.evaluator.tolerances
    if tolerances is not None and tolerances.noise > 1.0:
        # Weighed beside what is left, forms look much alike.
        most = max(least, thresholds.SHORTLIST * least)
    # What it does bends what tolerances do.
    fits = [
        refit_within(lines.evaluator, fit, criterion.nuisances)
        for fit in [*behind, *(f for f in beside if f.excess <= most)]
    ]
    return [f for f in fits if f.excess < lines.base.excess]


def fit_behind_joints(
    lines: Linearisation, criterion: Criterion
) -> list[CandidateFit]:
    """A fit with its dry friction behind a joint that gives way, which it has
    not yet: beside friction at the ring such a joint explains nothing. Refined,
    where that leaves much less.

    Args:
        lines: At a fit with dry friction.
        criterion: Of the campaign.
    """
    base, evaluator = lines.base, lines.evaluator
    most, found = thresholds.WORTH_A_SET * base.excess, []
    for i, (card, values) in enumerate(base.uses):
        if not card.dithered or card.contains:
            continue
        rest = (*base.uses[:i], *base.uses[i + 1 :])
        for form in evaluator.effects:
            uses = _joints(form, card, values)
            if any(form.cause == e.cause for e, _ in rest) or not uses:
                continue
            begun = [
                candidate_of(lines, (*rest, u), base.subject) for u in uses
            ]
            best = best_of_starts(lines, [c for c in begun if c is not None])
            fit = best and best.fit()
            if fit is not None and fit.excess < most:
                fit = refit_within(evaluator, fit, criterion.nuisances)
                found.append(fit)
    return found


def _joints(
    form: Effect, friction: Effect, values: np.ndarray
) -> list[tuple[Effect, np.ndarray]]:
    """A joint at its starts, with friction behind it; none where the form is
    none for it.
    """
    own = len(form.parameters) - len(values)
    is_at = form.at == friction.at
    if not is_at or friction.name not in form.contains or own < 1:
        return []
    starts = {tuple(start[:own]) for start in form.starts()}
    return [(form, np.append(start, values)) for start in sorted(starts)]


def _stepped(
    lines: Linearisation, begun: Sequence[Candidate | None]
) -> Candidate | None:
    """The candidate that begins best, after a round of steps."""
    able = [c for c in begun if c is not None]
    best = min(able, key=lambda c: c.excess, default=None)
    if best is None or not best.step(lines, thresholds.STEPS, own=True):
        return None
    return best


def _behind_joints(
    lines: Linearisation, card: Effect, start: np.ndarray
) -> list[Candidate | None]:
    """The fit with forms of its effects that contain the friction: what sticks
    behind a joint that gives way does not stick to the ring.
    """
    base, forms = lines.base, lines.evaluator.effects
    sets = behind_joints(base.uses, card, start, forms)
    return [candidate_of(lines, uses, base.subject) for uses in sets]
