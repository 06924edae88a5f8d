"""The criterion: what a set of effects leaves, and what each effect costs.

    score = ln(misfit + trust) / 2 + ln(predicted + trust) / 2
            + 4 known ln(max(1, stretch / 3)) + cost(n) + tied m

`misfit` is the mean square that a fit leaves above the noise, `predicted` the
same on motions that it has not seen: left out in turn
(`identification.held_out`), and new ones (`validation.new_runs`), `stretch` how
far numbers known to a tolerance are off (`devices.stretch`), n the number of
effects that are not within tolerances, m of those that have simpler special
cases; less is better. For residuals of unknown variance the first term
is the log likelihood per value (Gelman et al., Bayesian Data Analysis, section
3.2) and the second its cross-validated form, which an effect that only imitates
another does not share (Vehtari, Gelman, Gabry, Practical Bayesian model
evaluation using leave-one-out cross-validation, Statistics and Computing 27,
2017); the third is that of the tolerances themselves, as far as what is left is
known: no more than a right twin leaves. Trust is what a right
twin is exact to: below it less says nothing. A gap that no effect takes has to
be beyond the level, to which the noise itself is known. Numbers within their
tolerances are no part of the misfit, see `devices.tolerances`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.stretch import stretch_of, variance_over
from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.tolerated import holds_another, is_within


@dataclass(frozen=True)
class Criterion:
    """The gap of one campaign, and the score of what may explain it.

    Misfits are mean squares in units of the noise floor's.

    Attributes:
        nominal: The fit of the subject alone; what it leaves is the gap.
        count: Number of independent values.
        recorded: Share of the informative channels that was recorded.
        level: Misfit of a right twin: the noise is not known better, its laws
            are not, and it slips by chance.
        chance: Of that the last.
        least: Of a right twin, 0 or less: the recording has so much less noise
            than was thought.
        nuisances: Numbers known to a tolerance.
        is_last: Whether a verdict is decided by it, and no search goes on.
        is_foreign: Whether even the best explanation leaves an unknown law.
        law: A fit with terms of such a law in place of effects, if one was
            looked for and found.
    """

    nominal: CandidateFit
    count: int
    recorded: float = 1.0
    level: float = thresholds.LEVEL
    chance: float = 0.0
    least: float = 0.0
    nuisances: tuple[Nuisance, ...] = ()
    is_last: bool = False
    is_foreign: bool = False
    law: CandidateFit | None = None

    def misfit(self, fit: CandidateFit) -> float:
        """What a fit leaves above the floor on the runs that it was fitted
        to; below 0 by chance.
        """
        return fit.excess / self.count

    def misfits(self, fit: CandidateFit) -> tuple[float, float]:
        """What it leaves above the floor on its own runs, and on motions that
        it has not seen; the same where there is one motion alone.
        """
        inside = self.misfit(fit)
        return inside, inside if fit.held_out is None else fit.held_out

    def predicted(self, fit: CandidateFit) -> float:
        """The second of these, 0 where it is below."""
        return max(0.0, self.misfits(fit)[1])

    def left(self, fit: CandidateFit, level: float | None = None) -> float:
        """Geometric mean of both misfits, each with the level or another."""
        level = self.level if level is None else level
        both = (max(0.0, m - self.least) + level for m in self.misfits(fit))
        return math.sqrt(math.prod(both))

    def over(self, fits: Sequence[CandidateFit]) -> Criterion:
        """The same, with the noise that the best of fits shows: what a right
        twin leaves more than it is no more than it is exact to.
        """
        known = (f for f in fits if f.may_win)
        best = min((max(self.misfits(f)) for f in known), default=0.0)
        return replace(self, least=min(0.0, best + thresholds.TRUST))

    @property
    def trust(self) -> float:
        """Misfit to which fits are compared: the level without that of the
        noise, which is the same for all of them, and without what chance adds,
        which is in what they leave.
        """
        return self.findable - self.chance

    @property
    def findable(self) -> float:
        """Misfit below which no effect more is found: `trust` with chance."""
        return self.level - thresholds.LEVEL + thresholds.TRUST

    @property
    def beyond(self) -> float:
        """More than this, geometric mean of both misfits and the level, a right
        twin does not leave.
        """
        return thresholds.BEYOND_LEVEL * self.level

    def score(self, fit: CandidateFit) -> float:
        """Of a fit; the least one is the best explanation."""
        richer = sum(bool(e.generalises) for e in self.findings(fit))
        cost = cost_of(self.num_effects(fit)) + thresholds.TIED * richer
        return float(np.log(self.weighed(fit)) + cost)

    def weighed(self, fit: CandidateFit) -> float:
        """What a fit leaves, and what it stretches: the score without its
        costs, no logarithm.

        In a verdict stretch counts as far as what is left is known: more than a
        right twin leaves is of an unknown law, which stretches numbers too. A
        search goes on from what stretches them less.
        """
        return float(self.left(fit, self.trust) * np.exp(self.strain(fit)))

    def strain(self, fit: CandidateFit) -> float:
        """What the numbers that a fit stretches add to its score."""
        tail = thresholds.TAIL
        if self.is_last:
            tail *= self.known(fit)
        stretch = self.stretch(fit) / thresholds.WITHIN
        return float(tail * np.log(max(1.0, stretch)))

    def known(self, fit: CandidateFit) -> float:
        """How far what a fit leaves is known, 0 to 1: of no more than a right
        twin leaves, all is; beside an unknown law nothing.
        """
        if self.is_foreign:
            return 0.0
        return min(1.0, self.beyond / self.left(fit))

    def stretch(self, fit: CandidateFit) -> float:
        """Of the numbers of a fit, where what a right twin leaves beyond the
        noise may all lie along them.
        """
        known, more = fit.tolerances, self.level - thresholds.LEVEL
        if known is None or more <= 0.0:
            return fit.stretch
        rows = len(fit.solution.residual) - fit.num_prior
        least = variance_over(more * self.count, len(known.nuisances))
        return stretch_of(known, fit.solution.residual[:rows], least)

    def farthest(self, fit: CandidateFit) -> float:
        """Tolerances that numbers are off at most beside a fit: those of a
        machine, or what the fit itself stretches them to.
        """
        return max(thresholds.WITHIN, fit.stretch)

    def findings(self, fit: CandidateFit) -> list[Effect]:
        """A fit's effects that are not within tolerances."""
        return [
            use[0]
            for use in fit.uses
            if not is_within(use, fit.spread, self.nuisances)
        ]

    def num_effects(self, fit: CandidateFit) -> int:
        """How many of its effects are not within tolerances, those that others
        contain among them.
        """
        held = sum(holds_another(use, self.nuisances) for use in fit.uses)
        return len(self.findings(fit)) + held

    def named(self, fit: CandidateFit) -> frozenset[str]:
        """Their causes."""
        return frozenset(e.cause for e in self.findings(fit))

    def closed(self, fit: CandidateFit) -> float:
        """Share of the gap's amplitude that a fit takes away."""
        return closed_amplitude(self.misfit(self.nominal), self.misfit(fit))

    def unexplained(self, fit: CandidateFit) -> float:
        """Share of the gap's amplitude that a fit leaves beyond the level, on
        motions that it has not seen.
        """
        gap = self.left(self.nominal) - self.level
        rest = self.left(fit) - self.level
        before, after, least = (
            np.sqrt(1.0 + m) - 1.0 for m in (gap, rest, self.level)
        )
        if before <= 0.0:
            return 0.0
        return float(np.clip((after - least) / before, 0.0, 1.0))

    def is_beyond_level(self, fit: CandidateFit) -> bool:
        """Whether a fit leaves more than a right twin would."""
        return self.left(fit) > self.beyond

    def is_short(self, fit: CandidateFit) -> bool:
        """Whether a fit leaves more than a right twin would, or stretches
        numbers not to.
        """
        return self.left(fit) * math.exp(self.strain(fit)) > self.beyond

    def may_pay(self, fit: CandidateFit) -> bool:
        """Whether one effect more could better a fit's score at all."""
        number = self.num_effects(fit) + 1
        least = np.log(self.findable) + cost_of(number)
        return bool(self.score(fit) > least)

    def pays_below(self, best: CandidateFit, number: int) -> float:
        """What a set of so many effects leaves at most, as a sum of squares,
        that has a better score than a fit.
        """
        left = math.exp(self.score(best) - cost_of(number))
        return self.count * (left - self.trust + self.least)

    def is_material(self, fit: CandidateFit) -> bool:
        """Whether what it leaves is beyond the level and no small part of the
        gap: then something is there that the library has not.
        """
        share = self.unexplained(fit)
        return self.is_beyond_level(fit) and share > thresholds.MATERIAL


def cost_of(number: int) -> float:
    """What a set of so many effects costs in a score: ln C(K, n) over `ODDS`.

    Any number of effects is as likely beforehand, and so is each of the sets
    of as many of K causes (Scott and Berger, Bayes and empirical-Bayes
    multiplicity adjustment in the variable-selection problem, Annals of
    Statistics 38, 2010).
    """
    return math.log(math.comb(thresholds.CAUSES, number)) / thresholds.ODDS


def closed_amplitude(before: float, after: float) -> float:
    """Share of a gap's amplitude that is taken away, 1 at the floor.

    Amplitudes are sqrt(1 + misfit) - 1.

    Args:
        before, after: Misfits; below 0 they are chance.
    """
    first, last = (np.sqrt(1.0 + max(0.0, m)) - 1.0 for m in (before, after))
    return float(1.0 - last / first) if first > 0.0 else 0.0


def refined(fits: Sequence[CandidateFit]) -> list[CandidateFit]:
    """Fits whose search was led to its end, best first."""
    return sorted((f for f in fits if f.refined), key=lambda f: f.excess)
