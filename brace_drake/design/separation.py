"""How well a run would tell rivals apart: T-optimality.

With y_i the predictions of rival i, S the sensitivities to what is estimated
anyway and S_j those to the parameters of rival j, a run is worth, in squares
of the noise floor,

    T = min over ordered pairs i, j of
        min over phi, psi of |y_i - y_j - S phi - S_j psi|^2,

and the run with the largest T is the one to make: whichever rival i is right,
each other one j, fitted to that run, will leave at least that much (to first
order in its parameters).

Sources: Atkinson and Fedorov, The design of experiments for discriminating
between two rival models, Biometrika 62, 1975; Hunter and Reiner, Designs for
discriminating between two rival models, Technometrics 7, 1965.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from brace_drake.identification.least_squares import beyond, orthonormal_basis


@dataclass(frozen=True)
class PairSeparation:
    """What a run would leave between two rivals, squares of the floor."""

    first: str
    second: str
    separation: float


def separate_pairs(
    predictions: Mapping[str, np.ndarray],
    sensitivities: np.ndarray,
    own: Mapping[str, np.ndarray] | None = None,
) -> list[PairSeparation]:
    """Separation of each pair of rivals by one run, the least first.

    Args:
        predictions: Weighted recording (rows,) that each rival predicts.
        sensitivities: To what is estimated anyway (rows, n).
        own: To each rival's own parameters (rows, n_j), where it has some.
    """
    own = own or {}
    bases = {
        name: orthonormal_basis(
            np.column_stack([sensitivities, own[name]])
            if name in own
            else sensitivities
        )
        for name in predictions
    }
    found = []
    for first, second in itertools.combinations(predictions, 2):
        apart = predictions[first] - predictions[second]
        rests = [beyond(apart, bases[n]) for n in (first, second)]
        least = min(float(r @ r) for r in rests)
        found.append(PairSeparation(first, second, least))
    return sorted(found, key=lambda pair: pair.separation)


def choose_best(
    separations: Mapping[str, list[PairSeparation]],
) -> str | None:
    """The run whose worst pair is separated best; None without any.

    Args:
        separations: Of each run, as `separate_pairs` returns them.
    """
    worth = {name: p[0].separation for name, p in separations.items() if p}
    return max(worth, key=worth.__getitem__, default=None)
