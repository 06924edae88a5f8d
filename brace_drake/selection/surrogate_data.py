"""Surrogate-data test: what an effect's freedom alone would take of a gap.

A surrogate has as many parameters as the effect, and in each run the spectra
and the mixture of channels that the effect's sensitivities have, but the
phases of its frequencies are drawn at random, alike in all channels (Theiler
et al., Testing for nonlinearity in time series, Physica D 58, 1992; Prichard
and Theiler, Phys. Rev. Lett. 73, 1994). So it moves as much and as fast as the
effect, at other times. An effect that takes no more of the gap than its
surrogates has taken it by its freedom.

Some surrogates of an effect that hardly changes in time are copies of it.
Those tell nothing and are left out.
"""

from __future__ import annotations

import numpy as np

from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.whitening import in_frequency
from brace_drake.selection import thresholds

# Directions of less than this part of their columns are copies of others.
_COPY = 1e-10


def surrogate_gains(
    evaluator: Evaluator, nominal: CandidateFit, fit: CandidateFit, seed: int
) -> np.ndarray:
    """What surrogates of a fit's effects take off the nominal fit's misfit.

    Beyond what the subject's parameters take, in floors, ascending; to first
    order, which is all that a surrogate has. Copies of the effect are left
    out.

    Args:
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        fit: One that was searched.
        seed: Of the phases.
    """
    n, rows = len(fit.subject), evaluator.ends[-1]
    there = nominal.solution.residual[:rows]
    done = there - fit.solution.residual[:rows]
    kept = np.column_stack([nominal.solution.jacobian[:rows], there, done])
    own = fit.solution.jacobian
    # A surrogate pays what its effect pays for parameters far from usual.
    prior = own[rows:, n:]
    own = own[:rows, n:]
    gram = kept.T @ kept
    own_gram = own.T @ own + prior.T @ prior
    products = [
        _products(p, kept[begin:end], own[begin:end])
        for p, begin, end in zip(
            evaluator.prepared,
            [0, *evaluator.ends],
            evaluator.ends,
            strict=False,
        )
    ]
    generator = np.random.default_rng([seed, 29])
    taken = np.array(
        [
            _gains(gram, own_gram, sum(_turned(p, generator) for p in products))
            for _ in range(thresholds.NUM_SURROGATES)
        ]
    )
    inner, right = gram[:-2, :-2], gram[:-2, -1]
    whole = gram[-1, -1] - right @ _solve(inner, right)
    is_other = taken[:, 1] <= thresholds.SURROGATE_COPY * whole
    return np.sort(taken[is_other, 0]) / evaluator.count


def loses_to_surrogates(
    evaluator: Evaluator, nominal: CandidateFit, fit: CandidateFit, seed: int
) -> bool:
    """Whether one of a fit's surrogates takes as much of the gap as it does."""
    gains = surrogate_gains(evaluator, nominal, fit, seed)
    gain = (nominal.excess - fit.excess) / evaluator.count
    return bool(np.any(gains >= gain))


def _products(prepared: PreparedRun, first, second) -> np.ndarray:
    """Inner products over channels at each frequency, (F, n, m), complex."""
    a, b = (in_frequency(prepared, columns) for columns in (first, second))
    return np.einsum("fcn,fcm->fnm", np.conj(a), b, optimize=True)


def _turned(products: np.ndarray, generator) -> np.ndarray:
    """Inner products of the first with the second at phases drawn, (n, m)."""
    phases = np.exp(2j * np.pi * generator.random(len(products)))
    # A mean has but a sign.
    phases[0] = np.sign(phases[0].real)
    return np.einsum("f,fnm->nm", phases, products).real


def _gains(
    gram: np.ndarray, own_gram: np.ndarray, cross: np.ndarray
) -> list[float]:
    """Squares that columns take off the last two of others, beyond the rest."""
    inner, right = gram[:-2, :-2], gram[:-2, -2:]
    solved = _solve(inner, np.column_stack([cross[:-2], right]))
    m = cross.shape[1]
    beyond = own_gram - cross[:-2].T @ solved[:, :m]
    slopes = cross[-2:].T - cross[:-2].T @ solved[:, m:]
    found = _solve(beyond, slopes)
    return [float(slopes[:, i] @ found[:, i]) for i in range(2)]


def _solve(gram: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Gram^-1 right, over the directions that there are."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    inverse = np.linalg.pinv(gram / np.outer(size, size), _COPY, True)
    scaled = right / (size[:, None] if right.ndim > 1 else size)
    found = inverse @ scaled
    return found / (size[:, None] if right.ndim > 1 else size)
