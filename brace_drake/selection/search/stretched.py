"""What tolerances have to be stretched to, as effects.

Numbers within their tolerances take what they can of a gap, however far off
they then are. One that is off by many tolerances suggests itself as an effect;
dry friction, which no straight line follows, does so wherever something is
left.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.held_out import estimate_off
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search.candidate import make_candidate
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.shortlist import try_refine
from brace_drake.selection.search.within import refit_within


def fit_stretched(
    lines: Linearisation, criterion: Criterion, effects: Sequence[Effect]
) -> list[CandidateFit]:
    """A fit with one more effect of those that tolerances suggest, refined.

    Args:
        lines: At the fit that is looked at.
        criterion: Of the campaign.
        effects: Those that may be added.
    """
    base, found = lines.base, []
    known = len(criterion.findings(base))
    for effect, values in _suggested(lines.evaluator, criterion, base, effects):
        candidate = make_candidate(
            lines,
            [*base.effects, effect],
            [*base.values, values],
            base.subject,
            base.spread,
        )
        if candidate is None:
            continue
        if not candidate.step(lines, thresholds.STEPS, own=True):
            continue
        fit = try_refine(lines.evaluator, candidate.fit())
        if effect.dithered and not criterion.findings(fit)[known:]:
            # What is there on any machine bends what tolerances do.
            fit = refit_within(lines.evaluator, fit, criterion.nuisances)
        found.append(fit)
    return found


def _suggested(
    evaluator: Evaluator,
    criterion: Criterion,
    fit: CandidateFit,
    effects: Sequence[Effect],
) -> Iterator[tuple[Effect, np.ndarray]]:
    """Effects of numbers that are far off, the farthest first, with the values
    to set out from.
    """
    is_left = criterion.is_beyond_level(fit)
    numbers = sorted(estimate_off(evaluator, fit), key=lambda n: -abs(n[1]))
    tried: set[str] = set()
    for nuisance, t in numbers:
        ((card, values),) = nuisance.uses
        is_rough = card.dithered and is_left
        if card.key in tried or card not in effects:
            continue
        if abs(t) <= thresholds.WITHIN and not is_rough:
            continue
        tried.add(card.key)
        if card.spread is not None:
            yield card, card.off()
            continue
        start = values * (max(abs(t), 1.0) * np.sign(t or 1.0))
        start = np.clip(start, np.minimum(card.lower, 0.0), card.upper)
        start = np.where(card.lower < 0.0, start, np.abs(start))
        for form in effects:
            if form.name == card.name:
                yield form, start if np.any(start) else values
        if len(tried) >= thresholds.MOST_STRETCHED:
            return
