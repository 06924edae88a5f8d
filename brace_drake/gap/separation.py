"""How well a run would tell rivals apart: T-optimality.

With y_i the predictions of rival i and S the sensitivities to what is
estimated anyway, a run is worth, in squares of the noise floor,

    T = min over pairs i, j of min over phi of |y_i - y_j - S phi|^2,

and the run with the largest T is the one to make: whichever rival is right,
the others will then leave at least that much.

Sources: Atkinson and Fedorov, The design of experiments for discriminating
between two rival models, Biometrika 62, 1975; Hunter and Reiner, Designs for
discriminating between two rival models, Technometrics 7, 1965.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

# Sensitivities whose singular values are smaller, relative to the largest of
# unit columns, are copies of others.
_COPY = 1e-8


@dataclass(frozen=True)
class PairSeparation:
    """What a run would leave between two rivals, squares of the floor."""

    first: str
    second: str
    separation: float


def orthonormal_basis(columns: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the span of columns (rows, n): (rows, rank)."""
    size = np.linalg.norm(columns, axis=0)
    columns = columns[:, size > 0.0] / size[size > 0.0]
    if columns.shape[1] == 0:
        return columns
    left, values, _ = np.linalg.svd(columns, full_matrices=False)
    return left[:, values > _COPY * values[0]]


def beyond(vectors: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """What of vectors (rows,) or (rows, n) lies outside a basis."""
    return vectors - basis @ (basis.T @ vectors)


def separate_pairs(
    predictions: Mapping[str, np.ndarray], sensitivities: np.ndarray
) -> list[PairSeparation]:
    """Separation of each pair of rivals by one run, the least first.

    Args:
        predictions: Weighted recording (rows,) that each rival foresees.
        sensitivities: To what is estimated anyway (rows, n).
    """
    basis = orthonormal_basis(sensitivities)
    found = []
    for first, second in itertools.combinations(predictions, 2):
        rest = beyond(predictions[first] - predictions[second], basis)
        found.append(PairSeparation(first, second, float(rest @ rest)))
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
