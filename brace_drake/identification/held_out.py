"""What a fit leaves on motions that it has not seen, without another replay.

Each motion, with its repeats, is left out in turn. The parameters that the
others alone would give are one Gauss-Newton step away, with the sensitivities
at hand, and so is what they leave on the motion left out: the leave-one-out
residual of least squares (Stone, Cross-validatory choice and assessment of
statistical predictions, J. R. Stat. Soc. B 36, 1974), to first order. What a
flexible effect takes of the fit's own noise and errors it does not take there.

Parameters of a run of its own, such as the phase of a breath, are estimated
on it in any case.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.stretch import noise_along
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import calc_triangle
from brace_drake.identification.problem import CandidateProblem

# Weight that a motion left out keeps: what it alone tells of is not lost.
_KEPT = 0.1


def motions_of(prepared: list[PreparedRun]) -> list[list[int]]:
    """Places of the runs of each motion, repeats beside what they repeat."""
    groups: dict[str, list[int]] = {}
    for place, p in enumerate(prepared):
        groups.setdefault(p.run.repeat_of or p.run.file, []).append(place)
    return list(groups.values())


def check_fit(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """The fit with what it leaves on motions left out."""
    return replace(fit, held_out=held_out_misfit(evaluator, fit))


def estimate_off(
    evaluator: Evaluator, fit: CandidateFit
) -> list[tuple[Nuisance, float]]:
    """How many tolerances each number is off in a fit; what else the fit
    leaves counts as noise along them.
    """
    known = fit.tolerances
    if known is None:
        return []
    along = known.along(fit.solution.residual[: evaluator.ends[-1]])
    off = known.estimate(along, noise_along(known, along))
    return list(zip(known.nuisances, off.tolist(), strict=True))


def held_out_misfit(evaluator: Evaluator, fit: CandidateFit) -> float | None:
    """Mean square above the floor's, in floors, of motions left out in turn.

    None where there is one motion alone, or the fit was not searched.

    Args:
        evaluator: Over the fit runs.
        fit: Of them.
    """
    motions = motions_of(evaluator.prepared)
    if len(motions) < 2 or not fit.is_searched:
        return None
    problem = CandidateProblem(evaluator, fit.effects, fit.values, fit.spread)
    z, jacobian = fit.solution.z, fit.solution.jacobian
    problem.weigh_alike(fit.excess)
    # Places of the parameters that each run has of its own.
    own = [
        np.array(
            [i for e in fit.effects for i in problem.places_in_run(e, run)],
            dtype=int,
        )
        for run in range(len(evaluator.prepared))
    ]
    shared = np.setdiff1d(np.arange(len(z)), np.concatenate(own))
    triangles = []
    for mine, begin, end in zip(
        own, [0, *evaluator.ends], evaluator.ends, strict=False
    ):
        rows = slice(begin, end)
        # The run's own parameters first: what is below them is beyond them.
        columns = [jacobian[rows, mine], jacobian[rows][:, shared]]
        triangle = calc_triangle([*columns, fit.solution.residual[rows]])
        triangles.append(triangle[len(mine) :, len(mine) :])
    # Rows of a prior are no run's.
    prior = np.column_stack(
        [problem.prior_jacobian()[:, shared], problem.prior_rows(z)]
    )
    room = (
        np.maximum(problem.lower - z, -problem.radius)[shared],
        np.minimum(problem.upper - z, problem.radius)[shared],
    )
    left = sum(_left_on(motion, triangles, prior, room) for motion in motions)
    before = sum(float(t[:, -1] @ t[:, -1]) for t in triangles)
    return (fit.excess + left - before) / evaluator.count


def _left_on(motion, triangles, prior, room) -> float:
    """Squares left on a motion by the parameters that the others give."""
    weighed = [
        np.sqrt(_KEPT) * t if i in motion else t
        for i, t in enumerate(triangles)
    ]
    others = np.vstack([*weighed, prior])
    low = np.minimum(room[0], 0.0)
    high = np.maximum(room[1], low + 1e-15)
    size = np.linalg.norm(others[:, :-1], axis=0)
    # What the others do not tell of stays where it is.
    told = size > 0.0
    step = np.zeros(len(size))
    if told.any():
        step[told] = lsq_linear(
            others[:, :-1][:, told],
            -others[:, -1],
            (low[told], high[told]),
            method="bvls",
        ).x
    moved = np.append(step, 1.0)
    return sum(float(np.sum((triangles[i] @ moved) ** 2)) for i in motion)
