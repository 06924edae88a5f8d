"""What fits leave, take away and explain: the figures a decision rests on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from brace_drake.identification.evaluation import Evaluator, sticks
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds

if TYPE_CHECKING:
    from brace_drake.selection.null_bootstrap import NullDistribution


@dataclass(frozen=True)
class Criterion:
    """The gap of one campaign and what counts as an explanation of it.

    Misfits and gains are mean squares in units of the noise floor's.

    Attributes:
        nominal: The fit of the subject alone; what it leaves is the gap.
        count: Number of independent values.
        is_known: Whether instruments and nominal numbers are given by a data
            sheet, not taken from the recording itself.
        recorded: Share of the informative channels that was recorded.
        carries_friction: Whether drives stick by an effect that the twin
            carries anyway.
        null: What noise alone gives; None before it was drawn.
    """

    nominal: CandidateFit
    count: int
    is_known: bool
    recorded: float = 1.0
    carries_friction: bool = False
    null: NullDistribution | None = None

    def misfit(self, fit: CandidateFit) -> float:
        """What a fit leaves above the floor."""
        return fit.excess / self.count

    def gain(self, fit: CandidateFit, before: CandidateFit) -> float:
        """What a fit takes off another one's misfit."""
        return (before.excess - fit.excess) / self.count

    def gains(self, fit: CandidateFit, before: CandidateFit) -> bool:
        """Whether a fit takes more off another one's misfit than noise and the
        twin's own errors would give to as many parameters more.
        """
        more = max(1, fit.freedom - before.freedom)
        return self.gain(fit, before) > self.null.least_gain(more)

    def closed(self, fit: CandidateFit) -> float:
        """Share of the gap's amplitude that a fit takes away."""
        return closed_amplitude(self.misfit(self.nominal), self.misfit(fit))

    def closes_half(self, fit: CandidateFit) -> bool:
        """Whether a fit takes away about half of the gap's amplitude."""
        return self.closed(fit) >= thresholds.HALF

    def left(self, fit: CandidateFit) -> float:
        """What a fit leaves, and what no twin is exact to."""
        return max(0.0, self.misfit(fit)) + thresholds.TWIN_ERROR

    def sticking(self, fits: Sequence[CandidateFit]) -> list[CandidateFit]:
        """Single effects with which drives stick, if they are among the best
        and none of those explains all that there is.
        """
        known = [f for f in fits if f.is_searched]
        least = min((max(0.0, f.excess) for f in known), default=np.inf)
        if least <= self.null.misfit_threshold * self.count:
            return []
        near = thresholds.FRICTION_NEAR * least
        found = [f for f in known if f.excess <= near and f.sticks]
        found.sort(key=lambda f: f.excess)
        return found[: thresholds.NUM_FRICTIONS]

    def is_almost_near_floor(self, fit: CandidateFit) -> bool:
        """Whether screening leaves it where its end may be near the floor."""
        most = thresholds.UNFINISHED * thresholds.NEAR_FLOOR
        return self.misfit(fit) <= most

    @property
    def least_share(self) -> float:
        """Share of the gap's amplitude that an explanation takes away."""
        known = thresholds.SHARE_KNOWN
        return known if self.is_known else thresholds.SHARE_REAL

    def largest_rest(self, number: int, is_sticking: bool = False) -> float:
        """Misfit that an explanation by so many effects may leave.

        A real machine has more than one flaw, so one effect may leave a rest,
        if that is a small part of the gap's amplitude. Two effects together
        can cover much of any gap; on a bench with known instruments they may
        leave no more than the noise, or a hundredth of the amplitude, a tenth
        where drives stick.
        """
        gap = np.sqrt(1.0 + max(0.0, self.misfit(self.nominal))) - 1.0
        pair = thresholds.PAIR_SHARE
        if is_sticking:
            pair = thresholds.PAIR_SHARE_STICKING
        # Misfits of the amplitudes that these shares leave.
        most, least = (
            float((1.0 + (1.0 - share) * gap) ** 2 - 1.0)
            for share in (self.least_share, pair)
        )
        if number < 2 or not self.is_known:
            return most
        return min(most, max(thresholds.NEAR_FLOOR, least))

    def largest_excess(self, number: int) -> float:
        """Excess after screening from which an explanation can be reached."""
        gap = thresholds.UNFINISHED_SHARE * self.misfit(self.nominal)
        coarse = min(thresholds.NEAR_FLOOR, gap)
        most = thresholds.UNFINISHED * self.largest_rest(number)
        return max(most, coarse) * self.count

    def has_gap(self, fits: Sequence[CandidateFit]) -> bool:
        """Whether the nominal fit leaves more than its own noise would."""
        return self.misfit(self.nominal) > self.null.misfit_threshold or any(
            self.gains(f, self.nominal) for f in refined(fits)
        )

    def explains(self, fit: CandidateFit) -> bool:
        """Whether a fit explains the gap: down to what noise leaves, or by far
        most of it; and not with parameters that are no sample of their prior.
        """
        if not self.gains(fit, self.nominal):
            return False
        most = self.largest_rest(len(fit.effects), fit.sticks)
        little = self.misfit(fit) <= max(self.null.misfit_threshold, most)
        return bool(little) and fit.is_scattered

    def is_near_floor(self, fits: Sequence[CandidateFit]) -> bool:
        """Whether the best of fits leaves no more than noise would.

        Or a bit more, where drives stick and it closes much of the gap: no
        replay follows such a recording to the floor.
        """
        best = next(iter(plausible(fits)), None)
        if best is None:
            return False
        limit = self.null.misfit_threshold
        # Friction that the twin carries has taken its part before.
        if best.sticks and (self.carries_friction or self.closes_half(best)):
            limit = max(limit, thresholds.NEAR_FLOOR_STICKING)
        return self.misfit(best) <= limit

    def part_as_good(
        self, fit: CandidateFit, fits: Sequence[CandidateFit]
    ) -> CandidateFit | None:
        """Some of a fit's effects that leave no more without the others, but
        for what noise would gain; None where all are needed.
        """
        for part in refined(fits):
            if part.kinds < fit.kinds and not self.gains(fit, part):
                return part
        return None


def closed_amplitude(before: float, after: float) -> float:
    """Share of a gap's amplitude that is taken away, 1 at the floor.

    Amplitudes are sqrt(1 + misfit) - 1.

    Args:
        before, after: Misfits; below 0 they are chance.
    """
    first, last = (np.sqrt(1.0 + max(0.0, m)) - 1.0 for m in (before, after))
    return float(1.0 - last / first) if first > 0.0 else 0.0


def make_criterion(
    evaluator: Evaluator,
    nominal: CandidateFit,
    null: NullDistribution | None = None,
) -> Criterion:
    """The criterion of an evaluator's runs."""
    twin = evaluator.twin
    return Criterion(
        nominal,
        evaluator.count,
        twin.instruments_known,
        evaluator.recorded,
        sticks(twin, ()),
        null,
    )


def refined(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Fits whose search was led to its end, best first."""
    return sorted((f for f in fits if f.refined), key=lambda f: f.excess)


def plausible(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Refined fits whose many parameters may be a sample of their prior."""
    return [f for f in refined(fits) if f.is_scattered]
