"""Sensitivities of a residual to scaled parameters, by differences.

Where drives stick a recording answers small changes by fits and starts. What
they stick by is differenced over longer ways and to both sides; all else, where
they stick no more than within tolerances, as if they did not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.identification.problem import CandidateProblem


def calc_sensitivities(
    problem: CandidateProblem,
    z: np.ndarray,
    first: int = 0,
    base: np.ndarray | None = None,
) -> np.ndarray:
    """Columns of the Jacobian from parameter `first` on, prior rows below.

    Differences at the coarse plant step. Run parameters of all runs are
    differenced at once.

    Args:
        problem: Of the candidate.
        z: Scaled parameters.
        first: Of the columns.
        base: The coarse residual at z, where it is known.
    """
    # What is held has no column: it looks like what no run tells of.
    groups = [
        g for g in problem.groups if g[0] >= first and g[0] not in problem.fixed
    ]
    rows, steps = problem.evaluator.ends[-1], problem.steps
    size = rows + problem.num_prior, len(z) - first
    out = np.zeros(size, order="F")
    out[rows:] = problem.prior_jacobian()[:, first:]
    if not problem.is_rough:
        ways = np.where(z + steps > problem.upper, -steps, steps)
        for place, column in _differences(problem, z, base, ways, groups):
            out[:rows, place - first] = column
        return out
    rough = groups
    if problem.sticks_little:
        rough = [g for g in groups if problem.is_rough_at(g[0])]
        smooth = [g for g in groups if g not in rough]
        for place, column in _differences(
            problem, z, None, steps, smooth, smooth=True
        ):
            out[:rows, place - first] = column
    for ways in (steps, -steps) if rough else ():
        for place, column in _differences(problem, z, base, ways, rough):
            out[:rows, place - first] += column / 2.0
    return out


def _differences(
    problem: CandidateProblem,
    z: np.ndarray,
    base: np.ndarray | None,
    steps: np.ndarray,
    groups: Sequence[Sequence[int]],
    smooth: bool = False,
):
    """Places and columns of groups of parameters, of those whose twin does not
    break down.
    """
    points = [] if base is not None else [z]
    for group in groups:
        point = z.copy()
        point[group] += steps[group]
        points.append(point)
    moved = problem.batch(points, coarse=True, smooth=smooth)
    if base is None:
        base, *moved = moved
    rows = problem.evaluator.ends[-1]
    moved.reverse()
    for group in groups:
        # Megabytes each: none is kept for longer.
        residual = moved.pop()
        if residual is None:
            continue
        change = (residual - base)[:rows]
        if len(group) == 1:
            yield group[0], change / steps[group[0]]
            continue
        apart = _whitened_runs(problem, problem.coloured(change))
        for i, column in zip(group, apart.T, strict=True):
            yield i, column / steps[i]


def _whitened_runs(problem: CandidateProblem, rows: np.ndarray) -> np.ndarray:
    """What coloured rows have in each run alone, whitened (rows, runs)."""
    ends = problem.evaluator.ends
    if problem.tolerances is not None:
        return problem.tolerances.whiten_pieces(rows, ends)
    out = np.zeros((len(rows), len(ends)))
    for k, (begin, end) in enumerate(zip([0, *ends], ends, strict=False)):
        out[begin:end, k] = rows[begin:end]
    return out
