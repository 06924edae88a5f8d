"""The search for a law: terms of a dictionary, one after the other.

Each term is screened by a linearised replay in the closed loop, the best
predicted ones are fitted beside the subject and the terms before, and that of
the best score stays; further terms are of its block (orthogonal matching
pursuit: Pati, Rezaiifar, Krishnaprasad, Asilomar Conference 1993; in the loop,
so that nothing has to be differentiated). A term has to pay for itself, on
motions that are left out in turn as well; the search ends where no more is left
than a right twin leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from brace_drake.core.errors import BraceError
from brace_drake.core.progress import part_of
from brace_drake.discrepancy.starts import beginning_at, residual_peaks
from brace_drake.effects.card import Effect
from brace_drake.effects.unknown import is_term, terms_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, refined
from brace_drake.selection.ranking import best_of_kinds
from brace_drake.selection.search.friction import fit_friction
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.screening import (
    Say,
    by_effect,
    others,
    screen,
    search_best,
    silent,
)
from brace_drake.selection.search.shortlist import best_fits, refine
from brace_drake.selection.search.within import (
    refit_within,
    search_beside,
    set_out,
)

# Terms of a law, and how many of each round are searched at least.
MOST_TERMS, PLACES = 3, 4
# Of many terms only so many, predicted to leave least, are screened at all
# their starts and strengths.
_NEAR = 20
# Terms that may pay together alone, as two parts of one oblique force do.
_AHEAD = 2


class LawSearch:
    """The law of what fits leave, searched once for what stays as it is.

    Attributes:
        law: In place of effects; None where none was looked for or found.

    Args:
        evaluator: Over the fit runs.
    """

    def __init__(self, evaluator: Evaluator):
        self.evaluator = evaluator
        self._terms = list(terms_for(evaluator.twin.device).values())
        self.law: CandidateFit | None = None
        self._base: CandidateFit | None = None
        self._found: CandidateFit | None = None

    def explains(
        self, criterion: Criterion, fits: Sequence[CandidateFit]
    ) -> bool:
        """Whether a law in place of effects takes all that is left, where the
        best of these falls short.

        Args:
            criterion: Of the campaign.
            fits: Of the search so far.
        """
        last = replace(criterion, is_last=True).over(fits)
        ranked = best_of_kinds(last, [criterion.nominal, *fits])
        if not last.is_short(ranked[0]):
            return False
        none = next(f for f in ranked if not last.findings(f))
        law = self.beside(last, none)
        if law is none:
            return False
        self.law = law
        return not last.is_short(law)

    def beside(
        self, criterion: Criterion, base: CandidateFit, say: Say = silent
    ) -> CandidateFit:
        """A base with the terms that pay, or the base itself."""
        before = self._base
        if before is None or before.name != base.name:
            found = search_law(
                self.evaluator, criterion, base, self._terms, say
            )
            self._base, self._found = base, None if found is base else found
        return self._found or base


def search_law(
    evaluator: Evaluator,
    criterion: Criterion,
    base: CandidateFit,
    terms: Sequence[Effect],
    say: Say = silent,
) -> CandidateFit:
    """The base with the terms that pay, or the base itself.

    Args:
        evaluator: Over the fit runs.
        criterion: Of the campaign.
        base: The nominal fit, or one with the effects that are named.
        terms: Of the dictionary.
        say: Progress.
    """
    best = longer = base
    for number in range(MOST_TERMS):
        is_whole = not criterion.is_short(longer)
        if is_whole or len(longer.effects) >= evaluator.room:
            break
        part = part_of(say, number / MOST_TERMS, (number + 1) / MOST_TERMS)
        try:
            found = _one_more(evaluator, criterion, longer, terms, part)
        except BraceError:
            break
        if found is None:
            break
        longer = found
        blocks = {e.block for e in longer.effects if is_term(e)}
        terms = [t for t in terms if t.block in blocks]
        if criterion.score(longer) < criterion.score(best):
            best = longer
        elif len(longer.effects) >= len(best.effects) + _AHEAD:
            break
    return best


def _one_more(
    evaluator: Evaluator,
    criterion: Criterion,
    base: CandidateFit,
    terms: Sequence[Effect],
    say: Say,
) -> CandidateFit | None:
    """The base with the best term more; None where none could be fitted."""
    set_out(evaluator, base)
    lines = Linearisation(evaluator, search_beside(evaluator, base))
    peaks = residual_peaks(evaluator, base)
    fresh = [beginning_at(t, peaks) for t in terms if t.name not in base.kinds]
    if len(fresh) > 2 * _NEAR:
        quick = by_effect(screen(lines, fresh, say, is_quick=True))
        fresh = [first.added for first, *_ in quick[:_NEAR]]
    candidates = screen(lines, fresh, say)
    search_best(lines, candidates, say, PLACES)
    fits = refine(evaluator, best_fits(candidates), lines.remaining)
    best = _plainest(criterion, refined(fits))
    before, after = base.tolerances, best and best.tolerances
    if before and before.off is not None and after and after.off is None:
        # Its numbers go along again, as the base's do: they were put back.
        best = refit_within(evaluator, best, criterion.nuisances)
    if best and criterion.is_short(best):
        best = _with_friction(evaluator, criterion, best)
    return best


def _with_friction(
    evaluator: Evaluator, criterion: Criterion, fit: CandidateFit
) -> CandidateFit:
    """A fit with the dry friction that a tolerance allows for, where that was
    hidden by what it now takes.
    """
    set_out(evaluator, fit)
    try:
        lines = Linearisation(evaluator, fit)
        more = others(evaluator.effects, fit)
        found = fit_friction(lines, criterion, more)
    except BraceError:
        return fit
    return min([fit, *refined(found)], key=criterion.score)


def _plainest(
    criterion: Criterion, fits: Sequence[CandidateFit]
) -> CandidateFit | None:
    """Of those that explain about as much, that with the fewest numbers."""
    if not fits:
        return None
    least = min(criterion.score(f) for f in fits)
    near = [f for f in fits if criterion.score(f) < least + thresholds.TIED]
    return min(near, key=lambda f: (_num_shapes(f), criterion.score(f)))


def _num_shapes(fit: CandidateFit) -> int:
    return sum(int(e.is_continuous.sum()) for e in fit.effects)
