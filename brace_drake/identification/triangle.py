"""The triangle of a QR decomposition of tall matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# Rows at a time that stay in a processor's cache, with dozens of columns.
_ROWS = 2000


def calc_triangle(columns: Sequence[np.ndarray]) -> np.ndarray:
    """R of A = Q R, A the arrays beside each other.

    Block by block of rows, then of the triangles below each other: as exact as
    Householder's reflections of the whole, without their ways through memory
    (Demmel, Grigori, Hoemmen, Langou, Communication-optimal parallel and
    sequential QR and LU factorizations, SIAM J. Sci. Comput. 34, 2012).

    Args:
        columns: Arrays (m,) or (m, n_i).

    Returns:
        (min(m, n), n), n the sum of all n_i.
    """
    rows = len(columns[0])
    triangles = [
        np.linalg.qr(
            np.column_stack([c[at : at + _ROWS] for c in columns]), mode="r"
        )
        for at in range(0, rows, _ROWS)
    ]
    if len(triangles) == 1:
        return triangles[0]
    return np.linalg.qr(np.vstack(triangles), mode="r")
