"""Fits whose rests are known, of a thousand values."""

import numpy as np

from brace_drake.effects.registry import find_effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import LeastSquaresSolution

COUNT = 1000


def fit_of(
    keys: str,
    misfit: float,
    predicted: float | None = None,
    refined: bool = True,
    scattered: bool = True,
) -> CandidateFit:
    """A fit that leaves so much where it was fitted and, unless told otherwise,
    as much on motions left out.
    """
    effects = tuple(find_effect(k) for k in keys.split("+") if k)
    number = 1 + sum(len(e.parameters) for e in effects)
    solution = LeastSquaresSolution(
        np.ones(number), np.zeros(COUNT), None, 0, True
    )
    fit = CandidateFit(
        effects,
        np.ones(1),
        tuple(e.starts()[0] for e in effects),
        solution,
        np.ones(number),
        COUNT * misfit,
        None,
        2,
        refined=refined,
        held_out=misfit if predicted is None else predicted,
    )
    vars(fit)["is_scattered"] = scattered
    return fit
