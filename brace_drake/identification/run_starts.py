"""Where the runs of an effect with parameters of their own set out."""

from __future__ import annotations

import itertools

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.identification.problem import CandidateProblem


def best_run_starts(
    problem: CandidateProblem, z: np.ndarray, effect: Effect
) -> tuple[np.ndarray, np.ndarray | None]:
    """z with every run at the best of an effect's own starts, and the
    residual there; None where the twin breaks down.
    """
    runs, points = range(len(problem.evaluator.prepared)), []
    starts = (p.starts for p in effect.run_parameters)
    for start in itertools.product(*starts):
        point = z.copy()
        for run in runs:
            mine = problem.places_in_run(effect, run)
            point[mine] = np.array(start) / problem.scales[mine]
        points.append(point)
    found = problem.batch(points, coarse=True)
    if len(points) == 1:
        return z, found[0]
    kept = [(p, r) for p, r in zip(points, found, strict=True) if r is not None]
    if not kept:
        return z, None
    # Whitening mixes the runs: they are compared before it.
    kept = [(p, problem.coloured(r)) for p, r in kept]
    out, residual = z.copy(), kept[0][1].copy()
    ends = problem.evaluator.ends
    for run, (begin, end) in enumerate(zip([0, *ends], ends, strict=False)):
        costs = [r[begin:end] @ r[begin:end] for _, r in kept]
        point, chosen = kept[int(np.argmin(costs))]
        residual[begin:end] = chosen[begin:end]
        mine = problem.places_in_run(effect, run)
        out[mine] = point[mine]
    return out, problem.whitened(residual)
