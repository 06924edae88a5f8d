"""What pure noise does to the statistics of a diagnosis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.design.separation import beyond
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.prepare import noise_replicates

_REPLICATES = 6
_DRAWS = 400
# The level of the instruments' noise is trusted to 5 %, its square to 10 %: a
# repeat of one run shows no less (see `prepare`).
NOISE_TRUST = 0.10
# Effects of more parameters have priors that keep them from chance.
_FEW = 8
# What an effect may gain where the twin is not exact: for each parameter, and
# at the least and the most. Beside the right effect wrong ones of few gained
# up to 0.006, offsets of six lengths up to 0.014.
_GAIN_TRUST, _GAIN_TRUST_FROM, _GAIN_TRUST_TO = 0.005, 0.015, 0.03


@dataclass(frozen=True)
class NullDistribution:
    """Statistics of surrogates: the fitted nominal twin plus its own noise.

    Attributes:
        misfit: Mean squares of the weighted noise minus 1, per surrogate.
        gain: Largest relative gain of any effect, per surrogate.
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

        The surrogates' spread and the error of integration, and what the
        noise level of real instruments may be off unnoticed.
        """
        spread = np.quantile(self.misfit, 0.99) - np.median(self.misfit)
        return float(spread) + 4.0 * self.numerical + NOISE_TRUST

    def least_gain(self, freedom: int) -> float:
        """Largest gain that noise alone gives once in a hundred campaigns.

        And what an effect may take of the errors of the twin itself.

        Args:
            freedom: Parameters that it has.
        """
        chance = float(np.quantile(self.gain, 0.99))
        trust = max(_GAIN_TRUST_FROM, _GAIN_TRUST * freedom)
        if not self.is_known:
            trust = _GAIN_TRUST_TO
        return chance + 4.0 * self.numerical + min(trust, _GAIN_TRUST_TO)


def draw_null(
    evaluator: Evaluator,
    nominal: CandidateFit,
    fits: Sequence[CandidateFit],
    seed: int,
) -> NullDistribution:
    """Draws surrogates by combining noisy replays of the single runs.

    Effects act through their sensitivities at the end of their own fits,
    after projection on the subject's.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        fits: Fits of the effects, whose last Jacobians are used.
        seed: Of the draws.
    """
    noise = _weighted_noise(evaluator, nominal, seed)
    n = len(nominal.subject)
    columns = nominal.solution.jacobian
    seen = np.linalg.norm(columns, axis=0) > 0.0
    basis, _ = np.linalg.qr(columns[:, seen])
    bases = [
        _orthogonal_part(basis, fit, n)
        for fit in fits
        if fit.num_free <= _FEW and fit.is_searched
    ]
    parts = _project(evaluator, noise, [basis, *bases])
    generator = np.random.default_rng([seed, 11])
    runs = len(evaluator.prepared)
    misfit, gain = [], []
    for _ in range(_DRAWS):
        pick = generator.integers(_REPLICATES, size=runs)
        squares = sum(parts[r][i][0] for r, i in enumerate(pick))
        scores = [
            sum(parts[r][i][1][k] for r, i in enumerate(pick))
            for k in range(len(bases) + 1)
        ]
        explained = scores[0] @ scores[0]
        misfit.append((squares - explained) / evaluator.count - 1.0)
        gains = [float(s @ s) for s in scores[1:]]
        gain.append(max(gains, default=0.0) / evaluator.count)
    numerical = _numerical_error(evaluator, nominal)
    known = evaluator.twin.instruments_known
    return NullDistribution(np.array(misfit), np.array(gain), numerical, known)


def _weighted_noise(evaluator, nominal, seed):
    def one(run):
        noise = noise_replicates(
            evaluator.twin,
            run.motion,
            nominal.subject,
            (),
            [[seed, 13, run.seed, i] for i in range(_REPLICATES)],
        )
        return [run.weigh(e) for e in noise]

    return evaluator.map(one, [(p,) for p in evaluator.prepared])


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


def _numerical_error(evaluator, nominal) -> float:
    finer = evaluator.twin.finer()

    def one(run):
        fine = finer.simulate(run.motion, nominal.subject)
        difference = run.weigh(
            fine - evaluator.twin.simulate(run.motion, nominal.subject)
        )
        return difference @ difference

    return sum(evaluator.map(one, [(p,) for p in evaluator.prepared])) / (
        evaluator.count
    )
