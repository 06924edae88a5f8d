"""The verdict: is there a gap, which effects explain it, what is left."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, cost_of
from brace_drake.selection.ranking import Ranked, rank


@dataclass(frozen=True)
class Support:
    """How well one named effect is supported by itself.

    Attributes:
        name: Its cause: the effect, and its place.
        probability: That it is there, whatever else may be.
        closes: Share of the gap's amplitude that comes back without it, of
            what is closed with all.
    """

    name: str
    probability: float
    closes: float


@dataclass(frozen=True)
class Verdict:
    """The answer.

    Attributes:
        gap: Whether there is one beyond noise, tolerances and the subject's
            parameters.
        winner: The fit with the effects that are named, or None; beside them
            it may have some that are within tolerances.
        outside_library: Whether what is left is material: something is there
            that the library has not, beside the effects named.
        ambiguous_with: Rivals that the data cannot tell from the winner.
        probability: That effects and `outside_library` are right.
        supported: Each named effect, the largest first.
        unexplained: Share of the gap's amplitude that is left.
        contradicted: What validation runs say against it; empty where they
            confirm it.
    """

    gap: bool
    winner: CandidateFit | None
    outside_library: bool
    ambiguous_with: tuple[str, ...]
    probability: float
    supported: tuple[Support, ...] = ()
    unexplained: float = 0.0
    contradicted: str = ""

    @property
    def effects(self) -> tuple[str, ...]:
        """Causes that explain the gap, the largest first."""
        return tuple(s.name for s in self.supported)


def decide(criterion: Criterion, fits: Sequence[CandidateFit]) -> Verdict:
    """The verdict over the nominal fit and its rivals.

    The explanation of the least score is named, none where that is the nominal
    twin itself or a law of terms that are no effects; what it leaves is judged
    apart.

    Args:
        criterion: Of the campaign.
        fits: Of the search; those refined may win.
    """
    ranked = rank(criterion, [criterion.nominal, *fits])
    is_law = criterion.law is not None and (
        criterion.score(criterion.law) < ranked[0].score
    )
    if is_law:
        ranked = _with_law(criterion, ranked)
    best = ranked[0].fit
    outside = is_law or criterion.is_material(best)
    # Beside an unknown law, what numbers are stretched to says nothing.
    odds = _probabilities(ranked, 0.0 if outside else criterion.strain(best))
    sure = odds[0] * _sure_of_rest(criterion, best, outside)
    sure = with_less_known(_limited(sure), criterion.recorded)
    named = criterion.findings(best)
    if not named:
        gap = outside
        left = criterion.unexplained(best) if gap else 0.0
        within = best if best.effects else None
        return Verdict(gap, within, gap, (), sure, (), left)
    tied = [
        "+".join(e.cause for e in criterion.findings(r.fit))
        for r in ranked[1:]
        if criterion.findings(r.fit)
        and r.score - ranked[0].score < thresholds.TIED
    ]
    supported = tuple(
        sorted(
            (_support(criterion, best, e, ranked, odds) for e in named),
            key=lambda s: -s.closes,
        )
    )
    left = criterion.unexplained(best)
    return Verdict(True, best, outside, tuple(tied), sure, supported, left)


def _with_law(criterion: Criterion, ranked: list[Ranked]) -> list[Ranked]:
    """What names nothing first, with the score of the law that is beside it."""
    (none,) = (r for r in ranked if not criterion.named(r.fit))
    first = none._replace(score=criterion.score(criterion.law))
    return [first, *(r for r in ranked if r is not none)]


def _probabilities(ranked: Sequence[Ranked], strain: float) -> list[float]:
    """Of each explanation, from the differences of their scores (pseudo-BMA;
    Yao, Vehtari, Simpson, Gelman, Bayesian Analysis 13, 2018).

    What the best one stretches numbers to, which adds `strain` to its score,
    may be one effect more, searched or not.
    """
    least = ranked[0].score
    weights = [math.exp(-thresholds.ODDS * (r.score - least)) for r in ranked]
    others = sum(weights[1:])
    if strain > 0.0:
        more = cost_of(1) - strain
        others = max(others, math.exp(-thresholds.ODDS * more))
    return [w / (weights[0] + others) for w in weights]


def _sure_of_rest(
    criterion: Criterion, best: CandidateFit, outside: bool
) -> float:
    """Probability that what is left is judged rightly: that it is next to
    nothing, or that it is much.
    """
    far = math.log(criterion.left(best) / criterion.beyond)
    far = far if outside else max(-far, math.log(thresholds.MATERIAL))
    if not outside and criterion.is_beyond_level(best):
        share = criterion.unexplained(best)
        far = math.log(thresholds.MATERIAL / max(share, 1e-3))
    return 1.0 / (1.0 + math.exp(-thresholds.ODDS * far))


def _support(criterion, best, effect, ranked, odds) -> Support:
    """What speaks for one of the named effects."""
    sure = sum(
        p
        for r, p in zip(ranked, odds, strict=True)
        if effect.cause in criterion.named(r.fit)
    )
    others = criterion.named(best) - {effect.cause}
    same = (r.fit for r in ranked if criterion.named(r.fit) == others)
    without = next(same, criterion.nominal)
    closes = criterion.closed(best) - max(0.0, criterion.closed(without))
    return Support(effect.cause, _limited(sure), max(0.0, closes))


def contradict(verdict: Verdict, reason: str) -> Verdict:
    """The verdict with what validation runs say against it.

    Its effects are withdrawn: what makes other motions worse is not there.
    """
    sure = min(verdict.probability, 1.0 - verdict.probability)
    return replace(
        verdict,
        gap=True,
        winner=None,
        outside_library=True,
        ambiguous_with=(),
        probability=_limited(sure),
        supported=(),
        unexplained=1.0,
        contradicted=reason,
    )


def with_less_known(probability: float, known: float) -> float:
    """A probability drawn towards one half.

    Args:
        probability: With all that a campaign records.
        known: Share of that which is known.
    """
    return min(probability, 0.5 + (probability - 0.5) * known)


def _limited(probability: float) -> float:
    least = thresholds.UNSURE
    return min(max(probability, least), 1.0 - least)
