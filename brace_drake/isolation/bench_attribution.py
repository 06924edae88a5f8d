"""Attribution of the bench's gap: which runs, which columns."""

from __future__ import annotations

import itertools

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.whitening import in_time
from brace_drake.isolation.attribution import Moments, attribute, gather
from brace_drake.isolation.bench_disturbances import disturbances

# Recording that is looked at: enough to tell blocks apart, at a bounded cost.
_MOST_S = 26.0
_PIECE_S = 1.0


def attribute_bench(
    evaluator: Evaluator, nominal: CandidateFit, seed: int
) -> list[dict]:
    """Shares of the blocks in the gap of the fitted nominal twin."""
    return attribute(bench_moments(evaluator, nominal), seed)


def bench_moments(evaluator: Evaluator, nominal: CandidateFit) -> Moments:
    """Products of residual, subject and errors of the blocks, over time."""
    ends = [0, *evaluator.ends]
    parts = [slice(a, b) for a, b in itertools.pairwise(ends)]
    residual = nominal.solution.residual
    picked = pick_runs(evaluator, [residual[p] for p in parts])
    runs = [evaluator.prepared[i] for i in picked]
    answers = disturbances(runs, evaluator, nominal.subject)
    blocks = [b for b, columns in answers.items() if columns]
    owner = [-2, *[-1] * len(nominal.subject)]
    for i, block in enumerate(blocks):
        owner += [i] * len(answers[block])
    pieces = []
    for place, run in enumerate(runs):
        rows = parts[picked[place]]
        columns = [residual[rows], *nominal.solution.jacobian[rows].T]
        for block in blocks:
            columns += [changes[place] for changes in answers[block]]
        zero = np.zeros(run.num_weighted)
        series = np.array(
            [in_time(run, zero if c is None else c) for c in columns]
        )
        duration = run.run.time_s[-1] - run.run.time_s[0]
        count = max(1, round(duration / _PIECE_S))
        pieces += np.array_split(series, count, axis=1)
    return gather(blocks, owner, pieces)


def pick_runs(evaluator: Evaluator, residuals: list[np.ndarray]) -> list[int]:
    """Runs to look at: those of the largest gap, with and without contact."""
    prepared = evaluator.prepared
    excess = [r @ r / p.count for r, p in zip(residuals, prepared, strict=True)]
    order = [int(i) for i in np.argsort(excess)[::-1]]
    free = [i for i in order if not prepared[i].run.contact]
    touching = [i for i in order if prepared[i].run.contact]
    # One of each kind comes first: what a free run does not show is contact's.
    order = touching[:1] + free[:1] + touching[1:] + free[1:]
    picked, total = [], 0.0
    for i in order:
        time = prepared[i].run.time_s
        total += float(time[-1] - time[0])
        if picked and total > _MOST_S:
            break
        picked.append(i)
    return sorted(picked)
