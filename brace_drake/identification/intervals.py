"""Intervals that hold with coloured noise: the sandwich by simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.devices.replays import uses_in_run
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.prepare import noise_replicates

_REPLICATES = 12
_Z95 = 1.959964
# Nearness to a limit, relative to the allowed range, that counts as at it.
_AT_LIMIT = 1e-7


@dataclass(frozen=True)
class ParameterEstimate:
    """One fitted parameter with its doubt.

    `standard_error` is None where the runs say nothing of the parameter: then
    its interval is all that is allowed. `nominal` is None for an effect's.
    `fixed` tells that it was held at its value, and not estimated.
    """

    name: str
    unit: str
    value: float
    standard_error: float | None
    lower95: float
    upper95: float
    at_limit: bool
    nominal: float | None = None
    fixed: bool = False


@dataclass(frozen=True)
class EstimateTable:
    """Estimates of a fit.

    Attributes:
        parameters: Subject first, then the effects'.
        correlation: Of the estimates; 0 with those that have none.
        condition_number: Of the scaled, weighted Jacobian; None where it does
            not tell all parameters.
        num_subject: How many of them are the subject's.
    """

    parameters: tuple[ParameterEstimate, ...]
    correlation: np.ndarray
    condition_number: float | None
    num_subject: int


def estimate_table(
    evaluator: Evaluator, fit: CandidateFit, seed: int
) -> EstimateTable:
    """Standard errors from the twin's own noise, carried through the loop.

    The estimator is linear in small noise: dz = -(J'J)^-1 J' e. Its covariance
    is taken from replicates of e, run by run, so that correlation in time and
    between channels counts in full, with that of numbers within their
    tolerances; where the fit leaves more than noise, the
    covariance is scaled by that.
    """
    rows = evaluator.ends[-1]
    jacobian = fit.solution.jacobian
    seen = np.linalg.norm(jacobian, axis=0) > 0.0
    q, triangle = np.linalg.qr(jacobian[:, seen])
    inverse = np.linalg.pinv(triangle)
    inner, known = q[:rows], fit.tolerances
    if known is not None:
        # The residual is whitened of tolerances, the noise is not.
        inner = known.whiten(inner)
    score_covariance = _score_covariance(evaluator, fit, inner, seed)
    if known is not None:
        along = known.tolerated(q[:rows])
        score_covariance += along.T @ along
    # Prior rows, where there are any, are exact observations of unit variance.
    prior = q[rows:]
    score_covariance += prior.T @ prior
    misfit = max(0.0, fit.excess / evaluator.count)
    covariance = inverse @ score_covariance @ inverse.T * (1.0 + misfit)
    deviation = np.sqrt(np.diag(covariance))
    error = np.full(len(seen), np.inf)
    error[seen] = deviation
    correlation = np.eye(len(seen))
    correlation[np.ix_(seen, seen)] = covariance / np.maximum(
        np.outer(deviation, deviation), 1e-300
    )
    condition, is_fixed = None, np.zeros(len(seen), dtype=bool)
    known_subject = evaluator.twin.subject
    is_fixed[: len(known_subject)] = [p.is_fixed for p in known_subject]
    if (seen | is_fixed).all():
        singular = np.linalg.svd(triangle, compute_uv=False)
        condition = float(singular[0] / max(singular[-1], 1e-300))
    return EstimateTable(
        tuple(_estimates(evaluator, fit, error)),
        correlation,
        condition,
        len(fit.subject),
    )


def _score_covariance(evaluator, fit, q, seed):
    """Covariance of q'e over replicates of the noise e, run by run."""

    def score(run, rows):
        noise = noise_replicates(
            evaluator.twin,
            run.motion,
            fit.subject,
            uses_in_run(fit.uses, run.index),
            [[seed, 17, run.seed, i] for i in range(_REPLICATES)],
        )
        return [rows.T @ run.weigh(e) for e in noise]

    parts = np.split(q, evaluator.ends[:-1])
    tasks = list(zip(evaluator.prepared, parts, strict=True))
    scores = np.array(evaluator.map(score, tasks))
    # Runs are independent; so are the replicates of each.
    return np.einsum("rmi,rmj->ij", scores, scores) / _REPLICATES


def _estimates(evaluator, fit, error):
    """Estimates of each scaled parameter, the subject's first."""
    moved = [(p.name, p, p.nominal) for p in evaluator.twin.subject]
    for effect in fit.effects:
        moved += [(p.name, p, None) for p in effect.parameters if not p.choices]
        moved += [
            (f"{p.name} of {prepared.run.name}", p, None)
            for prepared in evaluator.prepared
            for p in effect.run_parameters
        ]
    values, errors = fit.solution.z * fit.scales, error * fit.scales
    for (name, p, nominal), value, sigma in zip(
        moved, values.tolist(), errors.tolist(), strict=True
    ):
        if nominal is not None and p.is_fixed:
            ends = p.nominal, p.nominal
            yield ParameterEstimate(
                name, p.unit, p.nominal, None, *ends, False, nominal, True
            )
            continue
        margin = _AT_LIMIT * (p.upper - p.lower)
        yield ParameterEstimate(
            name,
            p.unit,
            value,
            sigma if np.isfinite(sigma) else None,
            # Beyond its limits the parameter has no meaning.
            max(p.lower, value - _Z95 * sigma),
            min(p.upper, value + _Z95 * sigma),
            bool(value - p.lower < margin or p.upper - value < margin),
            nominal,
        )
