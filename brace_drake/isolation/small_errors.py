"""What small errors of blocks change, and so could explain of a gap."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brace_drake.core.block_bootstrap import pieces_of
from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import SmallError
from brace_drake.devices.twin import Request
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.whitening import in_time
from brace_drake.isolation.attribution import attribute, gather

# Recording that is looked at: enough to tell blocks apart, at a bounded cost.
_MOST_S = 26.0


def attribute_errors(
    evaluator: Evaluator,
    nominal: CandidateFit,
    errors: Sequence[SmallError],
    seed: int,
) -> list[dict]:
    """Shares of the blocks in the gap of the fitted nominal twin.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        errors: Of the device; without any nothing is known.
        seed: Of the bootstrap over pieces of time.
    """
    if not errors:
        return []
    parts = [slice(a, b) for a, b in itertools.pairwise([0, *evaluator.ends])]
    last, solution = evaluator.ends[-1], nominal.solution
    residual, jacobian = solution.residual[:last], solution.jacobian[:last]
    known, tolerated = nominal.tolerances, np.zeros((len(residual), 0))
    if known is not None:
        # Errors are not whitened of tolerances: these stand beside them.
        residual, jacobian = known.colour(residual), known.colour(jacobian)
        tolerated = known.basis
    picked = pick_runs(evaluator, [residual[p] for p in parts])
    runs = [evaluator.prepared[i] for i in picked]
    answers = _responses(evaluator, nominal.subject, errors, runs)
    blocks = list(dict.fromkeys(block for block, _ in answers))
    kept = len(nominal.subject) + tolerated.shape[1]
    owner = [-2, *[-1] * kept]
    # Columns of one block stand together.
    answers.sort(key=lambda answer: blocks.index(answer[0]))
    owner += [blocks.index(block) for block, _ in answers]
    pieces = []
    for place, run in enumerate(runs):
        rows, zero = parts[picked[place]], np.zeros(run.count)
        columns = [residual[rows], *jacobian[rows].T, *tolerated[rows].T]
        columns += [changes.get(place, zero) for _, changes in answers]
        series = np.array([in_time(run, column) for column in columns])
        pieces += pieces_of(run.run, series, axis=1)
    return attribute(gather(blocks, owner, pieces), seed)


def _responses(
    evaluator: Evaluator,
    subject: np.ndarray,
    errors: Sequence[SmallError],
    runs: Sequence[PreparedRun],
) -> list[tuple[str, dict[int, np.ndarray]]]:
    """What small errors change in runs, by the coarse twin in closed loop.

    Returns:
        Block and weighted change by place of the run; an error that every run
        has of its own comes apart for each of them.
    """
    twin = evaluator.twin.coarse()

    def respond(run):
        each = [error.uses(run) for error in errors]
        acting = [i for i, uses in enumerate(each) if uses]
        uses = [(), *(each[i] for i in acting)]
        base, *moved = twin.simulate_each(
            [Request(run.motion, subject, own) for own in uses]
        )
        if base is None:
            raise BraceError("the nominal twin breaks down")
        logs = dict(zip(acting, moved, strict=True))
        return [
            None if logs.get(i) is None else run.weigh(logs[i] - base)
            for i in range(len(each))
        ]

    changes = evaluator.map(respond, [(run,) for run in runs])
    found: list[tuple[str, dict[int, np.ndarray]]] = []
    for error, answers in zip(errors, zip(*changes, strict=True), strict=True):
        if not error.is_own:
            found.append((error.block, {}))
        for place, change in enumerate(answers):
            if change is None:
                continue
            if error.is_own:
                found.append((error.block, {}))
            found[-1][1][place] = change
    return found


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
