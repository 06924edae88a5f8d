"""Two effects at once: which pairs could, and what they come to."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.search.candidate import Candidate, make_candidate
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.screening import Say, search_best
from brace_drake.selection.search.shortlist import try_refine

# A direction counts where it is not a copy of others, relative to the largest.
_COPY = 1e-6

# Excess that a pair is predicted to leave, and its two as they are alone.
PredictedPair = tuple[float, Candidate, Candidate]


def predict_pairs(
    base: Linearisation, singles: Sequence[Candidate]
) -> list[PredictedPair]:
    """Pairs of different effects, those first that would leave least.

    Each single spans the way to where it stands and, where it was searched,
    its derivatives there; what two spans together take off the nominal
    residual is a linear problem. Of several starts the best pair counts.
    """
    if len(singles) < 2:
        return []
    spans = [_span(base, candidate) for candidate in singles]
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
    right = (matrix.T @ base.unreachable).astype(float)
    ridge = np.concatenate([_ridge(base, c) for c in singles])
    diagonal = np.diag(gram)
    place = np.diag_indices(len(gram))
    gram[place] = np.maximum(diagonal + ridge / size**2, 0.02 * diagonal)
    best: dict[tuple[str, str], tuple] = {}
    for i, j in itertools.combinations(range(len(singles)), 2):
        first, second = singles[i].added, singles[j].added
        if first.is_alike(second):
            continue
        both = np.concatenate([places[i], places[j]])
        inverse = np.linalg.pinv(gram[np.ix_(both, both)], _COPY, True)
        taken = right[both] @ inverse @ right[both]
        names = first.name, second.name
        if taken > best.get(names, (-1.0,))[0]:
            best[names] = taken, singles[i], singles[j]
    found = [(base.excess - taken, i, j) for taken, i, j in best.values()]
    return sorted(found, key=lambda row: row[0])


def _span(base: Linearisation, candidate: Candidate) -> np.ndarray:
    vectors = [candidate.residual[: base.rows] - base.residual]
    if candidate.jacobian is not None:
        vectors.append(candidate.jacobian[: base.rows, _shared(candidate)])
    return base.beyond(np.column_stack(vectors)).astype(np.float32)


def _ridge(base: Linearisation, candidate: Candidate) -> np.ndarray:
    """Precision of the prior on the columns of a span, noise taken off."""
    noise = -base.added_noise(candidate.problem, candidate.z)
    if candidate.jacobian is None:
        return np.array([noise])
    prior = candidate.problem.prior_jacobian()
    return np.append(noise, (prior**2).sum(axis=0)[_shared(candidate)])


def _shared(candidate: Candidate) -> slice:
    """Places of a single effect's parameters, those of runs left out."""
    n = candidate.problem.num_subject
    return slice(n, n + int(candidate.added.is_continuous.sum()))


def search_pairs(
    base: Linearisation,
    predicted: Sequence[PredictedPair],
    say: Say,
    bar: float,
    enough: float,
) -> list[Candidate]:
    """Searches pairs from where their effects are alone.

    Args:
        base: The nominal fit.
        predicted: The pairs, best first.
        say: Progress.
        bar: Pairs that are predicted to leave more are not searched.
        enough: Excess of an explanation.
    """
    found = []
    for excess, first, second in predicted:
        if excess > bar:
            break
        pair = _make_pair(base, first, second, base.base.subject)
        if pair is not None:
            pair.predicted = excess
            found.append(pair)
    search_best(base, found, say, 1, enough, must_explain=True)
    return found


def _make_pair(
    base: Linearisation,
    first: Candidate,
    second: Candidate,
    subject: np.ndarray,
    strengths: Sequence[float] = (1.0, 1.0),
) -> Candidate | None:
    """The effects of two beside a subject; None where the twin breaks down.

    Args:
        base: Where they set out from.
        first, second: As they are alone.
        subject: Values of its parameters.
        strengths: Of each, in terms of that; of dozens of parameters none.
    """
    effects, values, spread = [], [], None
    for candidate, strength in zip((first, second), strengths, strict=True):
        problem = candidate.problem
        _, uses = problem.split(candidate.z)
        effects += [e for e, _ in uses]
        values += [
            v if e.is_flexible else e.scaled(v, strength) for e, v in uses
        ]
        if problem.has_spread:
            spread = problem.spread * problem.spread_scale
    return make_candidate(base, effects, values, subject, spread)


def search_afresh(
    base: Linearisation, pair: PredictedPair, enough: float, say: Say
) -> list[Candidate]:
    """A pair that sets out from the subject's nominal parameters.

    Two large effects drive those of the nominal fit to their limits, from
    where no way may lead back. Alone each does what it can of the other's, so
    either may be too strong: what leaves least of both is where it begins.

    Args:
        base: The nominal fit.
        pair: One that is predicted.
        enough: Excess at which the search may end.
        say: Progress.

    Returns:
        It where it stands then; none where its twin breaks down.
    """
    subject = np.array([p.nominal for p in base.evaluator.twin.subject])
    starts = [
        _make_pair(base, *pair[1:], subject, strengths)
        for strengths in itertools.product(thresholds.STRENGTHS, repeat=2)
    ]
    found = [c for c in starts if c is not None]
    if not found:
        return []
    best = min(found, key=lambda c: c.excess)
    say(f"cause {best.fit().name}", 0.9)
    before = base.base.excess
    for _ in range(thresholds.AFRESH_ROUNDS):
        if not best.step(base, thresholds.AFRESH_STEPS, own=True):
            break
        left = best.fit().excess
        if left <= enough or left > thresholds.WORTH_A_PAIR_ROUND * before:
            break
        before = left
    return [best]


def without_one(
    base: Linearisation, pair: CandidateFit, least: float
) -> list[CandidateFit]:
    """Either effect of a pair alone, from where the pair has it.

    A pair whose one effect does little may show where the other belongs.

    Args:
        base: The nominal fit.
        pair: A fit of two effects.
        least: Excess that one alone has to leave less than.
    """
    found = []
    for effect, values in pair.uses:
        candidate = make_candidate(
            base, [effect], [values], pair.subject, pair.spread
        )
        if candidate and candidate.step(base, thresholds.WITHOUT_ONE_STEPS):
            fit = candidate.fit()
            if fit.excess < least:
                found.append(try_refine(base.evaluator, fit))
    return found
