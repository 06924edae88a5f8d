"""Forward steps: a second effect where no single one explains the gap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, plausible, refined
from brace_drake.selection.search.candidate import Candidate
from brace_drake.selection.search.joint_refit import (
    implausible,
    refine_best,
    refit_with_second,
)
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.nested import (
    confused_with_many,
    search_richer,
    special_cases,
)
from brace_drake.selection.search.pairs import (
    predict_pairs,
    search_afresh,
    search_pairs,
    without_one,
)
from brace_drake.selection.search.screening import (
    Say,
    others,
    screen,
    search_best,
)
from brace_drake.selection.search.shortlist import (
    best_fits,
    best_of_each,
    try_refine,
)


class SecondEffects:
    """The search for pairs, from what is cheap to what is dear.

    It ends as soon as what is left is what noise leaves too, or when it has
    cost too many replays.

    Attributes:
        is_cut: Whether it has ended because of its cost, nothing found.
        found: Fits so far, refined.

    Args:
        base: The nominal fit.
        effects: Those that may be one of a pair.
        fits: Of single effects of few parameters: beside dozens of them any
            other effect looks right, and their search from afar is dear.
        candidates: Of the screening that they are from.
        criterion: With its null distribution.
        seed: Of places where searches begin again.
    """

    def __init__(
        self,
        base: Linearisation,
        effects: Sequence[Effect],
        fits: Sequence[CandidateFit],
        candidates: Sequence[Candidate],
        criterion: Criterion,
        seed: int,
    ):
        self._base, self._candidates = base, candidates
        self._criterion, self._effects, self._seed = criterion, effects, seed
        self._evaluator, self._nominal = base.evaluator, base.base
        self._singles, self.found = list(fits), []
        # Beside which second effects were tried, and what was refitted.
        self._beside: CandidateFit | None = None
        self._refitted: CandidateFit | None = None
        self._begun, self._spent = base.evaluator.replays, 0
        self._enough = criterion.largest_excess(2)
        self.is_cut = False

    def try_at_rest(self, fits: Sequence[CandidateFit], say: Say) -> bool:
        """Second effects beside what shows in the leg lengths at rest, where
        these are off: whatever else there is, this is part of it.

        What it costs is no part of what the other searches may.

        Args:
            fits: Of effects of dozens of parameters that show there.
            say: Progress, shares of this search.

        Returns:
            Whether a pair explains the gap to the floor.
        """
        self._refit(implausible(fits), say)
        self._begun = self._evaluator.replays
        return self._is_done()

    def try_pairs(self, say: Say) -> bool:
        """Pairs beside the single effect that explains, if one does, then
        those that single effects predict.

        Args:
            say: Progress, shares of this search.

        Returns:
            Whether one explains the gap to the floor.
        """
        if self._is_settled() and not self._is_done():
            # What is little beside a large effect shows only beside it.
            self._try_all_beside(say, of_many=False)
        if not self._is_done():
            self._try_predicted(say)
        is_done = self._is_done() and not self.is_cut
        self._spent = self._evaluator.replays - self._begun
        return is_done

    def _try_predicted(self, say: Say) -> None:
        """Pairs predicted, then the best of them with one of its two alone."""
        bar = self._bar()
        if np.isfinite(bar) and len(plausible(self._all())[0].effects) == 1:
            # As screening has left them: then all are equally unfinished.
            left = [f.excess for f in best_fits(self._candidates)]
            bar = thresholds.WORTH_A_SECOND * min(left, default=np.inf)
        predicted = predict_pairs(self._base, self._candidates)
        predicted = predicted[: thresholds.NUM_PAIRS]
        found = search_pairs(self._base, predicted, say, bar, self._enough)
        found += search_richer(self._base, found, self._effects)
        self._keep(found, self._nominal.excess, bar)
        for pair in predicted[: thresholds.PAIRS_AFRESH]:
            if self._is_settled():
                break
            afresh = search_afresh(self._base, pair, self._enough, say)
            self._keep(afresh, self._nominal.excess)
        least = min((f.excess for f in self._singles), default=np.inf)
        for pair in refined(self.found)[:1]:
            self.found += without_one(
                self._base, pair, thresholds.WORTH_A_SECOND * least
            )

    def search(
        self, fits: Sequence[CandidateFit], say: Say
    ) -> list[CandidateFit]:
        """What is dearer, and all that was found: pairs, and single effects
        found on the way, refined.

        Args:
            fits: Of more single effects.
            say: Progress, shares of this search.
        """
        self._singles += fits
        # Other searches may have come between.
        self._begun = self._evaluator.replays - self._spent
        if not self._is_done():
            self._try_many(lambda w, share: say(w, 0.3 * share))
        if not self._is_done():
            self._try_all_beside(say)
        half = [f for f in self._all() if self._criterion.closes_half(f)]
        doubtful = implausible(half)
        if doubtful and not self._is_done():
            self._refit(doubtful, say)
        if doubtful and not (self._is_done() or self._is_settled()):
            self._keep_single(doubtful[0])
        self._try_special_cases(say)
        return best_of_each(self.found)

    def _best_pairs(self) -> list[CandidateFit]:
        return [f for f in refined(self.found) if len(f.effects) == 2]

    def _try_special_cases(self, say: Say) -> None:
        """Special cases of the best pair, which are compared with it."""
        pairs = self._best_pairs()
        known = {f.name for f in pairs}
        for pair in pairs[:1]:
            for special in special_cases(self._base, pair, self._effects):
                name = special.fit().name
                say(f"cause {name}", 0.9)
                if name in known:
                    continue
                # Where two have driven the subject to, its own way counts.
                if special.step(self._base, thresholds.STEPS, own=True):
                    self._keep([special], self._nominal.excess)

    def _try_many(self, say: Say) -> None:
        """An effect of many parameters in the place of one of the best pair."""
        for pair in self._best_pairs()[:1]:
            for other in confused_with_many(self._base, pair, self._effects):
                search_best(self._base, [other], say, enough=self._enough)
                self._keep([other], pair.excess)

    def _refit(self, doubtful: Sequence[CandidateFit], say: Say) -> None:
        """The best of those whose parameters are no sample of their prior,
        with a second effect, unless that was tried before or the gap is
        explained.
        """
        best = next(iter(doubtful), self._refitted)
        if best is not self._refitted and not self._is_settled():
            self._refitted = best
            seconds = others(self._effects, best, flexible=False)
            found = refit_with_second(self._evaluator, best, seconds, say)
            self.found += found

    def _keep_single(self, fit: CandidateFit) -> None:
        """Leads the search of a single effect to its end, if that explains."""
        most = self._criterion.largest_excess(1)
        if not fit.refined and fit.excess <= most:
            self.found.append(try_refine(self._evaluator, fit))

    def _try_all_beside(self, say: Say, of_many: bool = True) -> None:
        """Second effects beside the single one that leaves least, those of few
        parameters first, unless they were tried beside it before.
        """
        # On the way a better single one may have shown.
        singles = [f for f in plausible(self._all()) if len(f.effects) == 1]
        best = next(iter(singles), self._nominal)
        if not self._criterion.closes_half(best):
            return
        is_tried, self._beside = best is self._beside, best
        try:
            beside = Linearisation(self._evaluator, best)
        except BraceError:
            return
        if not is_tried:
            self._try_beside(beside, False, lambda w, s: say(w, 0.3 + 0.3 * s))
        enough = not of_many or self._is_done()
        if not (enough or self._is_rough(best)):
            self._try_beside(beside, True, lambda w, s: say(w, 0.6 + 0.4 * s))

    def _try_beside(
        self, beside: Linearisation, flexible: bool, say: Say
    ) -> None:
        """Second effects beside the best single one.

        Two effects need not look like the sum of their small selves.
        """
        single, bar = beside.base, self._bar()
        if flexible:
            # So much freedom has to be predicted to take much.
            bar = min(bar, thresholds.WORTH_A_SECOND * single.excess)
        found = screen(beside, others(self._effects, single, flexible), say)
        search_best(
            beside, found, say, bar=bar, enough=self._enough, must_explain=True
        )
        found += search_richer(beside, found, self._effects)
        self._keep(found, single.excess, bar)

    def _keep(
        self,
        candidates: Sequence[Candidate],
        remaining: float,
        bar: float = np.inf,
    ) -> None:
        """Refines the best of candidates and keeps them."""
        self.found += refine_best(
            self._criterion,
            self._evaluator,
            candidates,
            remaining,
            self._seed,
            bar,
        )

    def _all(self) -> list[CandidateFit]:
        return [*self._singles, *self.found]

    def _is_settled(self) -> bool:
        return any(self._criterion.explains(f) for f in refined(self._all()))

    def _is_done(self) -> bool:
        """Whether what is left is what noise leaves too."""
        spent = self._evaluator.replays - self._begun
        if spent > thresholds.MOST_REPLAYS:
            self.is_cut = not self._is_settled()
            return True
        near = self._criterion.is_near_floor(self._all())
        return near and self._is_settled()

    def _is_rough(self, fit: CandidateFit) -> bool:
        """Whether the gap is explained, but for a rough rest of the fit's.

        Where drives stick, replays come to no floor: what little is left is no
        sign of effects of dozens of parameters, and their search is dear.
        """
        is_little = self._criterion.is_almost_near_floor(fit)
        return self._is_settled() and fit.sticks and is_little

    def _bar(self) -> float:
        """Excess above which a pair is not worth its second effect."""
        if not self._is_settled():
            return np.inf
        return thresholds.WORTH_A_SECOND * min(
            f.excess for f in plausible(self._all())
        )
