"""The null distribution: what noise alone does to misfits and gains.

Parametric bootstrap under the null hypothesis of no gap: fault-free campaigns
are simulated by the fitted nominal twin with its own noise (Efron and
Tibshirani, An Introduction to the Bootstrap, 1993, chapter 6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import beyond
from brace_drake.identification.prepare import noise_replicates
from brace_drake.selection import thresholds


@dataclass(frozen=True)
class NullDistribution:
    """Statistics of simulated fault-free campaigns.

    Attributes:
        misfit: Mean squares of the weighted noise minus 1, per campaign.
        gain: Largest gain of any effect, per campaign.
        numerical: Mean squares that halving the plant step would change.
        is_known: Whether instruments and nominal numbers are, so that the twin
            is as exact as a twin can be.
    """

    misfit: np.ndarray
    gain: np.ndarray
    numerical: float
    is_known: bool = True

    @property
    def misfit_threshold(self) -> float:
        """What a misfit must exceed to be more than noise.

        The spread of fault-free campaigns and the error of integration, and
        what the noise level of real instruments may be off unnoticed.
        """
        high = np.quantile(self.misfit, thresholds.NULL_QUANTILE)
        spread = float(high - np.median(self.misfit))
        return spread + 4.0 * self.numerical + thresholds.NOISE_LEVEL

    def least_gain(self, freedom: int) -> float:
        """Largest gain that noise alone gives once in a hundred campaigns.

        And what an effect may take of the errors of the twin itself.

        Args:
            freedom: Parameters that it has.
        """
        chance = float(np.quantile(self.gain, thresholds.NULL_QUANTILE))
        errors = thresholds.GAIN_PER_PARAMETER * freedom
        errors = max(thresholds.LEAST_GAIN, errors)
        if not self.is_known:
            errors = thresholds.MOST_GAIN
        errors = min(errors, thresholds.MOST_GAIN)
        return chance + 4.0 * self.numerical + errors


def draw_null(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fits: Sequence[CandidateFit],
    seed: int,
) -> NullDistribution:
    """Draws fault-free campaigns, noisy replays of single runs combined.

    Effects act through their sensitivities at the end of their own fits,
    after projection on the subject's.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        fits: Fits of the effects, whose last Jacobians are used.
        seed: Of the draws.
    """
    replayed = evaluator.map(
        partial(_replay_noise, evaluator.twin, nominal.subject, seed),
        [(p,) for p in evaluator.prepared],
    )
    noise = [replicates for replicates, _ in replayed]
    numerical = sum(error for _, error in replayed) / evaluator.count
    n = len(nominal.subject)
    columns = nominal.solution.jacobian
    seen = np.linalg.norm(columns, axis=0) > 0.0
    basis, _ = np.linalg.qr(columns[:, seen])
    bases = [
        _orthogonal_part(basis, fit, n)
        for fit in fits
        if fit.num_free <= thresholds.NULL_PARAMETERS and fit.is_searched
    ]
    parts = _project(evaluator, noise, [basis, *bases])
    generator = np.random.default_rng([seed, 11])
    runs = len(evaluator.prepared)
    misfit, gain = [], []
    for _ in range(thresholds.NULL_DRAWS):
        pick = generator.integers(thresholds.NULL_REPLICATES, size=runs)
        squares = sum(parts[r][i][0] for r, i in enumerate(pick))
        scores = [
            sum(parts[r][i][1][k] for r, i in enumerate(pick))
            for k in range(len(bases) + 1)
        ]
        explained = scores[0] @ scores[0]
        misfit.append((squares - explained) / evaluator.count - 1.0)
        gains = [float(s @ s) for s in scores[1:]]
        gain.append(max(gains, default=0.0) / evaluator.count)
    known = evaluator.twin.instruments_known
    return NullDistribution(np.array(misfit), np.array(gain), numerical, known)


def _replay_noise(twin, subject, seed, run) -> tuple[list, float]:
    """Weighted noise of a run, replicate by replicate, and the square of what
    halving the plant step changes.
    """
    seeds = [[seed, 13, run.seed, i] for i in range(thresholds.NULL_REPLICATES)]
    noise = noise_replicates(twin, run.motion, subject, (), seeds)
    fine = twin.finer().simulate(run.motion, subject)
    change = run.weigh(fine - twin.simulate(run.motion, subject))
    return [run.weigh(e) for e in noise], change @ change


def _orthogonal_part(basis, fit, n):
    """Orthonormal columns of an effect beyond the subject's."""
    columns = fit.solution.jacobian[: len(basis), n:]
    columns = beyond(columns, basis)
    norms = np.linalg.norm(columns, axis=0)
    columns = columns[:, norms > 1e-9]
    return np.linalg.qr(columns)[0] if columns.size else columns


def _project(evaluator, noise, bases):
    """Squares and scores of each run's replicates."""
    parts, at = [], 0
    for replicates in noise:
        size = len(replicates[0])
        rows = [b[at : at + size] for b in bases]
        parts.append([(e @ e, [b.T @ e for b in rows]) for e in replicates])
        at += size
    return parts
