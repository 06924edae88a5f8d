"""Two effects at once: which pairs could, and what they come to."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brace_drake.selection.search.candidate import Runner, make_runner
from brace_drake.selection.search.linearisation import Ground
from brace_drake.selection.search.screening import search_best

# A direction counts where it is not a copy of others, relative to the largest.
_COPY = 1e-6


# What a pair is foreseen to leave, and its two as they are alone.
Foreseen = tuple[float, Runner, Runner]


def search_pairs(
    ground: Ground,
    foreseen: Sequence[Foreseen],
    say=lambda what, share: None,
    bar: float = np.inf,
    enough: float = np.inf,
) -> list[Runner]:
    """Runs pairs.

    Args:
        ground: The nominal fit.
        foreseen: The pairs, best first.
        say: Progress.
        bar: Pairs that promise to leave more are not run.
        enough: As `most` of `search_best`.
    """
    pairs = []
    for promise, first, second in foreseen:
        if promise > bar:
            break
        runner = line_up_pair(ground, first, second, ground.leader.subject)
        if runner is not None:
            runner.promise = promise
            pairs.append(runner)
    search_best(ground, pairs, say, 1, enough, must_explain=True)
    return pairs


def foresee_pairs(ground: Ground, singles: Sequence[Runner]) -> list[Foreseen]:
    """Pairs of different effects, those first that would leave least.

    Each single spans the way to where it stands and, where it was searched,
    its derivatives there; what two spans together take off the nominal
    residual is a linear problem. Of several starts the best pair counts.

    Returns:
        Foreseen sum of squares above noise, and the two, for each pair.
    """
    if len(singles) < 2:
        return []
    spans = [_span(ground, runner) for runner in singles]
    ends = np.cumsum([s.shape[1] for s in spans])
    places = [
        np.arange(e - s.shape[1], e) for s, e in zip(spans, ends, strict=True)
    ]
    matrix = np.concatenate(spans, axis=1)
    del spans
    size = np.linalg.norm(matrix, axis=0)
    size[size < _COPY * size.max()] = np.inf
    matrix /= size
    gram = (matrix.T @ matrix).astype(float)
    right = (matrix.T @ ground.left).astype(float)
    ridge = np.concatenate([_ridge(ground, r) for r in singles])
    diagonal = np.diag(gram)
    place = np.diag_indices(len(gram))
    gram[place] = np.maximum(diagonal + ridge / size**2, 0.02 * diagonal)
    best = {}
    for i, j in itertools.combinations(range(len(singles)), 2):
        names = _name(singles[i]), _name(singles[j])
        if singles[i].card.is_alike(singles[j].card):
            continue
        both = np.concatenate([places[i], places[j]])
        inverse = np.linalg.pinv(gram[np.ix_(both, both)], _COPY, True)
        taken = right[both] @ inverse @ right[both]
        if taken > best.get(names, (-1.0,))[0]:
            best[names] = taken, singles[i], singles[j]
    total = ground.excess
    found = [(total - taken, i, j) for taken, i, j in best.values()]
    return sorted(found, key=lambda row: row[0])


def _name(runner: Runner) -> str:
    return runner.problem.effects[0].name


def _span(ground: Ground, runner: Runner) -> np.ndarray:
    vectors = [runner.residual[: ground.rows] - ground.residual]
    if runner.jacobian is not None:
        vectors.append(runner.jacobian[: ground.rows, _shared(runner)])
    span = ground.beyond(np.column_stack(vectors))
    return span.astype(np.float32)


def _ridge(ground: Ground, runner: Runner) -> np.ndarray:
    """Precision of the prior on the columns of a span, noise taken off."""
    noise = -ground.added_noise(runner.problem, runner.z)
    if runner.jacobian is None:
        return np.array([noise])
    prior = runner.problem.prior_jacobian()
    return np.append(noise, (prior**2).sum(axis=0)[_shared(runner)])


def _shared(runner: Runner) -> slice:
    """Places of a single effect's parameters, those of runs left out."""
    n = runner.problem.num_subject
    return slice(n, n + int(runner.problem.effects[0].is_continuous.sum()))


def line_up_pair(
    ground: Ground,
    first: Runner,
    second: Runner,
    subject: np.ndarray,
    strengths: Sequence[float] = (1.0, 1.0),
) -> Runner | None:
    """The effects of two beside a subject; None where the twin breaks down.

    Args:
        ground: Where they set out from.
        first, second: As they are alone.
        subject: Values of its parameters.
        strengths: Of each, in terms of that; of dozens of parameters none.
    """
    effects, values, spread = [], [], None
    for runner, strength in zip((first, second), strengths, strict=True):
        problem = runner.problem
        _, uses = problem.split(runner.z)
        effects += [e for e, _ in uses]
        values += [
            v if e.is_flexible else e.scaled(v, strength) for e, v in uses
        ]
        if problem.has_spread:
            spread = problem.spread * problem.spread_scale
    return make_runner(ground, effects, values, subject, spread)
