"""A second effect, where no single one explains all that there is."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import sticks
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.acceptance import (
    is_almost_near_floor,
    largest_excess,
)
from brace_drake.selection.decision import (
    explains,
    is_near_floor,
    plausible,
    refined,
)
from brace_drake.selection.measures import closes_half, is_flexible
from brace_drake.selection.null_bootstrap import NullDistribution
from brace_drake.selection.search.candidate import Runner, step
from brace_drake.selection.search.joint_refit import lead_back, strays
from brace_drake.selection.search.linearisation import Ground
from brace_drake.selection.search.nested import race_richer
from brace_drake.selection.search.pair_moves import (
    make_richer,
    make_simpler,
    set_out_afresh,
    try_without_one,
)
from brace_drake.selection.search.pairs import foresee_pairs, search_pairs
from brace_drake.selection.search.restart import is_caught, restart
from brace_drake.selection.search.screening import race, search_best
from brace_drake.selection.search.shortlist import (
    best_fits,
    best_of_each,
    refine,
    try_refine,
)
from brace_drake.selection.search.small_second import (
    race_fewer,
    try_small_second,
)

# Beside one that explains most, two have to leave half as much.
_HALF = 0.5
# Pairs that are searched inside the twin, of all that are foreseen.
_SEARCHED = 4
# Replays of all runs after which no other search is begun.
_DEAR = 500
# Pairs that set out afresh.
_AFRESH = 2
# Steps of the search of a special case.
_STEPS = 5

Say = Callable[[str, float], None]


class SecondEffects:
    """The search for pairs, from what is fast to what is dear.

    It ends as soon as what is left is what surrogates leave too, or when it
    has cost too much.

    Attributes:
        is_cut: Whether it has ended because of its cost, nothing found.

    Args:
        ground: The nominal fit.
        cards: Effects that may be one of a pair.
        fits: Of single effects of few parameters: beside dozens of them any
            other effect looks right, and their search from afar is dear.
        runners: Of the race that they are from.
        null: What noise alone gives.
        seed: Of places where searches begin again.
    """

    def __init__(
        self,
        ground: Ground,
        cards: Sequence[Effect],
        fits: Sequence[CandidateFit],
        runners: Sequence[Runner],
        null: NullDistribution,
        seed: int,
    ):
        self._ground, self._runners, self._null = ground, runners, null
        self._cards, self._seed = cards, seed
        self._evaluator, self._nominal = ground.evaluator, ground.leader
        self._singles, self._found = list(fits), []
        # Beside which second effects were tried, and what was led back.
        self._leader: CandidateFit | None = None
        self._stray: CandidateFit | None = None
        self._begun, self._spent = ground.evaluator.replays, 0
        self._most = largest_excess(self._evaluator, self._nominal, 2)
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
        self._lead_back(strays(fits), say)
        self._begun = self._evaluator.replays
        return self._is_done()

    def try_small(
        self, fits: Sequence[CandidateFit], say: Say
    ) -> list[CandidateFit]:
        """Pairs of the single effect that explains, be it to the floor, with
        a second one that takes little; where it is one of dozens of parameters
        that shows in the leg lengths at rest, pairs of few that do.

        Args:
            fits: Of more single effects.
            say: Progress, shares of this search.
        """
        singles = plausible([*self._singles, *fits])
        leader = next(iter(singles), self._nominal)
        if not self._does_explain(leader):
            return []
        if is_flexible(leader) and leader.effects[0].at_rest:
            return self._try_fewer(leader, say)
        try:
            beside = Ground(self._evaluator, leader)
        except BraceError:
            return []
        cards = self._others(leader, flexible=False)
        return try_small_second(beside, cards, self._null, say)

    def _try_fewer(self, many: CandidateFit, say: Say) -> list[CandidateFit]:
        at_rest = [f for f in self._singles if f.effects[0].at_rest]
        for fit in sorted(at_rest, key=lambda f: f.excess)[:1]:
            cards = self._others(fit, flexible=False)
            found = race_fewer(self._evaluator, fit, many, cards, say)
            self._keep(found, fit.excess)
        return best_of_each(self._found)

    def try_pairs(self, say: Say) -> bool:
        """Pairs beside the single effect that explains, if one does, then
        those that are foreseen from the ways of single effects.

        Args:
            say: Progress, shares of this search.

        Returns:
            Whether one explains the gap to the floor.
        """
        if self._is_settled() and not self._is_done():
            # What is little beside a large effect shows only beside it.
            self._try_all_beside(say, of_many=False)
        if not self._is_done():
            self._try_foreseen(say)
        is_done = self._is_done() and not self.is_cut
        self._spent = self._evaluator.replays - self._begun
        return is_done

    def _try_foreseen(self, say: Say) -> None:
        """Pairs foreseen, then the best of them with one of its two alone."""
        bar = self._bar()
        if np.isfinite(bar) and len(plausible(self._all())[0].effects) == 1:
            # As the race has left them: then all are equally unfinished.
            left = [f.excess for f in best_fits(self._runners)]
            bar = _HALF * min(left, default=np.inf)
        foreseen = foresee_pairs(self._ground, self._runners)[:_SEARCHED]
        found = search_pairs(self._ground, foreseen, say, bar, self._most)
        found += race_richer(self._ground, found, self._cards)
        self._keep(found, self._nominal.excess, bar)
        for pair in foreseen[:_AFRESH]:
            if self._is_settled():
                break
            runners = set_out_afresh(self._ground, pair, self._most, say)
            self._keep(runners, self._nominal.excess)
        least = min((f.excess for f in self._singles), default=np.inf)
        for pair in refined(self._found)[:1]:
            self._found += try_without_one(self._ground, pair, _HALF * least)

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
            self._try_richer(lambda w, share: say(w, 0.3 * share))
        if not self._is_done():
            self._try_all_beside(say)
        strayed = strays([f for f in self._all() if self._is_half(f)])
        if strayed and not self._is_done():
            self._lead_back(strayed, say)
        if strayed and not (self._is_done() or self._is_settled()):
            self._keep_single(strayed[0])
        self._try_simpler(say)
        return best_of_each(self._found)

    def _try_simpler(self, say: Say) -> None:
        """Special cases of the best pair, which are compared with it."""
        pairs = [f for f in refined(self._found) if len(f.effects) == 2]
        for pair in pairs[:1]:
            known = {f.name for f in pairs}
            for runner in make_simpler(self._ground, pair, self._cards):
                name = runner.fit().name
                say(f"cause {name}", 0.9)
                if name in known:
                    continue
                # Where two have driven the subject to, its own way counts.
                if step(self._ground, runner, _STEPS, own=True):
                    self._keep([runner], self._nominal.excess)

    def _try_richer(self, say: Say) -> None:
        pairs = [f for f in refined(self._found) if len(f.effects) == 2]
        for pair in pairs[:1]:
            for runner in make_richer(self._ground, pair, self._cards):
                search_best(self._ground, [runner], say, most=self._most)
                self._keep([runner], pair.excess)

    def _lead_back(self, strayed: Sequence[CandidateFit], say: Say) -> None:
        """The best of those that went astray, with a second effect, unless it
        was tried before or the gap is explained.
        """
        best = next(iter(strayed), self._stray)
        if best is not self._stray and not self._is_settled():
            self._stray = best
            cards = self._others(best, flexible=False)
            self._found += lead_back(self._evaluator, best, cards, say)

    def _is_half(self, fit: CandidateFit) -> bool:
        """Whether a fit closes about half of the gap."""
        return closes_half(self._evaluator, self._nominal, fit)

    def _keep_single(self, fit: CandidateFit) -> None:
        """Leads the search of a single effect to its end, if that explains."""
        most = largest_excess(self._evaluator, self._nominal, 1)
        if not fit.refined and fit.excess <= most:
            self._found.append(try_refine(self._evaluator, fit))

    def _try_all_beside(self, say: Say, of_many: bool = True) -> None:
        """Second effects beside the single one that leaves least, those of few
        parameters first, unless they were tried beside it before.
        """
        # On the way a better single one may have shown.
        singles = [f for f in plausible(self._all()) if len(f.effects) == 1]
        leader = next(iter(singles), self._nominal)
        if not self._is_half(leader):
            return
        is_tried, self._leader = leader is self._leader, leader
        try:
            beside = Ground(self._evaluator, leader)
        except BraceError:
            return
        if not is_tried:
            self._try_beside(beside, False, lambda w, s: say(w, 0.3 + 0.3 * s))
        enough = not of_many or self._is_done()
        if not (enough or self._is_rough(leader)):
            self._try_beside(beside, True, lambda w, s: say(w, 0.6 + 0.4 * s))

    def _all(self) -> list[CandidateFit]:
        return [*self._singles, *self._found]

    def _is_settled(self) -> bool:
        return any(self._does_explain(f) for f in refined(self._all()))

    def _does_explain(self, fit: CandidateFit) -> bool:
        return explains(self._evaluator, self._nominal, fit, self._null)

    def _is_done(self) -> bool:
        """Whether what is left is what surrogates leave too."""
        if self._evaluator.replays > self._begun + _DEAR:
            self.is_cut = not self._is_settled()
            return True
        limit = self._null.misfit_threshold
        return self._is_settled() and is_near_floor(
            self._evaluator, self._nominal, self._all(), limit
        )

    def _is_rough(self, leader: CandidateFit) -> bool:
        """Whether the gap is explained, but for a rough rest of the leader's.

        Where drives stick, replays come to no floor: what little is left is no
        sign of effects of dozens of parameters, and their search is dear.
        """
        uses, twin = leader.uses, self._evaluator.twin
        is_little = is_almost_near_floor(self._evaluator, leader)
        return self._is_settled() and sticks(twin, uses) and is_little

    def _bar(self) -> float:
        """Excess above which a pair is not worth its second effect."""
        if not self._is_settled():
            return np.inf
        return _HALF * min(f.excess for f in plausible(self._all()))

    def _keep(
        self, runners: Sequence[Runner], there: float, bar: float = np.inf
    ) -> None:
        """Refines the contenders of a race and keeps them."""
        good = [f for f in best_fits(runners) if f.excess <= bar]
        good = refine(self._evaluator, good, there, self._most)
        self._found += refined(good)
        # The nominal fit is no pair, so never caught.
        best = min(good, key=lambda f: f.excess, default=self._nominal)
        if is_caught(self._evaluator, self._nominal, best, self._null):
            self._found += restart(self._evaluator, best, self._seed)

    def _try_beside(self, beside: Ground, flexible: bool, say: Say) -> None:
        """Second effects beside the best single one.

        Two effects need not look like the sum of their small selves.
        """
        leader = beside.leader
        others = self._others(leader, flexible)
        bar = self._bar()
        if flexible:
            # With so much freedom those drawn alike have to promise much.
            bar = min(bar, _HALF * leader.excess)
        found = race(
            beside, others, say, bar=bar, most=self._most, must_explain=True
        )
        found += race_richer(beside, found, self._cards)
        self._keep(found, leader.excess, bar)

    def _others(self, leader: CandidateFit, flexible: bool) -> list[Effect]:
        """Cards that are no other form of what the leader has."""
        return [
            c
            for c in self._cards
            if c.is_flexible == flexible
            and not any(c.is_alike(e) for e in leader.effects)
        ]
