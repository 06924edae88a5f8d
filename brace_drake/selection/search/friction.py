"""Dry friction within its tolerance, as an effect.

Other numbers act on a straight line within their tolerances; drives that stick
a little do not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.held_out import estimate_off
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.level import tolerated_friction
from brace_drake.selection.search.candidate import (
    Candidate,
    make_candidate,
    with_one_more,
)
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.shortlist import other_choices
from brace_drake.selection.search.within import refit_within


def fit_friction(
    lines: Linearisation, criterion: Criterion, effects: Sequence[Effect]
) -> list[CandidateFit]:
    """A fit with dry friction that a tolerance allows for, in each of its
    forms, where something is left; refined.

    Args:
        lines: At the fit that is looked at.
        criterion: Of the campaign.
        effects: Those that may be added.
    """
    found = []
    power = tolerated_friction(lines.evaluator, lines.base, np.inf)
    if power < thresholds.WORTH_FRICTION * criterion.misfit(lines.base):
        return []
    for nuisance, t in estimate_off(lines.evaluator, lines.base):
        ((card, values),) = nuisance.uses
        if not card.dithered:
            continue
        start = np.minimum(values * max(t, 1.0), card.upper)
        behind = _behind_joints(lines, card, start)
        forms = [e for e in effects if e.name == card.name]
        searched = (
            [c for c in behind if c.step(lines, thresholds.STEPS, own=True)]
            if behind
            else _in_each_form(lines, forms, start)
        )
        found += [c.fit() for c in searched]
    best = min(found, key=lambda f: f.excess, default=lines.base)
    # It takes of what is left, not of what tolerances are stretched to.
    if best.excess > thresholds.GAINED * max(0.0, lines.excess):
        return []
    # What it does bends what tolerances do.
    fit = refit_within(lines.evaluator, best, criterion.nuisances)
    return [fit] if fit.excess < lines.base.excess else []


def _in_each_form(
    lines: Linearisation, forms: Sequence[Effect], start: np.ndarray
) -> list[Candidate]:
    """The fit with friction, searched in the form that begins best, and in
    others from where that one ends.
    """
    begun = [with_one_more(lines, form, start) for form in forms]
    able = [c for c in begun if c is not None]
    best = min(able, key=lambda c: c.excess, default=None)
    if best is None or not best.step(lines, thresholds.STEPS, own=True):
        return []
    return [best, *other_choices(lines, best.fit())]


def _behind_joints(
    lines: Linearisation, card: Effect, start: np.ndarray
) -> list[Candidate]:
    """The fit with forms of its effects that contain the friction: what sticks
    behind a joint that gives way does not stick to the ring.
    """
    base, found = lines.base, []
    forms = lines.evaluator.effects
    for place, (effect, values) in enumerate(base.uses):
        for form in forms:
            if form.name != effect.name or card.name not in form.contains:
                continue
            if len(form.parameters) != len(values) + len(start):
                continue
            both, mine = list(base.effects), list(base.values)
            both[place], mine[place] = form, np.append(values, start)
            found.append(make_candidate(lines, both, mine, base.subject))
    return [c for c in found if c is not None]
