"""What lies in the span of columns, and what lies beyond it."""

from __future__ import annotations

import numpy as np

# Columns whose singular values are smaller, relative to the largest of unit
# columns, are copies of others.
_COPY = 1e-8


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
