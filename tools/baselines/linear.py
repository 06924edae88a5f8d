"""Least squares over signatures, by inner products alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tools.baselines.case import Case
from tools.baselines.signatures import Signature

# Misfit that means no gap: the square of the noise is known to a tenth.
LEVEL = 0.10
# What leaves more of the gap's amplitude than this explains nothing.
UNEXPLAINED = 0.5
# Relative, what is added to the diagonal of small systems.
_RIDGE = 1e-9


@dataclass(frozen=True)
class LinearFit:
    """Some signatures fitted beside the subject.

    Attributes:
        signatures: Which.
        strengths: Of each one's columns.
        misfit: Mean square left above the noise's, in floors.
    """

    signatures: tuple[Signature, ...]
    strengths: tuple[np.ndarray, ...]
    misfit: float

    @property
    def places(self) -> np.ndarray:
        """Of its columns (n,)."""
        return places_of(self.signatures)

    @property
    def vector(self) -> np.ndarray:
        """Strengths of all its columns (n,)."""
        return np.concatenate(self.strengths)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects, in order."""
        return tuple(sorted(s.effect.name for s in self.signatures))

    @property
    def blocks(self) -> list[str]:
        """Of the effects."""
        return sorted({s.effect.block for s in self.signatures})

    @property
    def num_free(self) -> int:
        """Numbers beyond the subject's."""
        return sum(s.num_free for s in self.signatures)


def places_of(signatures: Sequence[Signature]) -> np.ndarray:
    """Of all their columns (n,)."""
    return np.concatenate(
        [np.arange(s.first, s.first + s.size) for s in signatures]
    )


class Linear:
    """Fits of a case's signatures.

    Attributes:
        case: Whose.
        misfit: What the nominal twin leaves, mean square above the noise's.
    """

    def __init__(self, case: Case):
        self.case, n = case, case.num_subject
        gram = case.gram
        seen = np.flatnonzero(np.diag(gram)[:n] > 0.0)
        self._seen, self._subject = seen, gram[np.ix_(seen, seen)]
        self._along = _solve(self._subject, gram[seen, n:])
        self._gram = gram[n:, n:] - gram[seen, n:].T @ self._along
        self.misfit = self._left(self._gram[-1, -1])

    def _left(self, square: float) -> float:
        return float(square) / self.case.count - 1.0

    def fit(self, signatures: Sequence[Signature]) -> LinearFit | None:
        """Some of them together; None where one had to be negative that
        cannot be.
        """
        places = places_of(signatures)
        matrix = self._gram[np.ix_(places, places)]
        right = -self._gram[places, -1]
        x = _solve(matrix, right)
        ends = np.cumsum([s.size for s in signatures])[:-1]
        strengths = tuple(np.split(x, ends))
        pairs = zip(signatures, strengths, strict=True)
        if any(s.has_one_sign and v[0] <= 0.0 for s, v in pairs):
            return None
        left = self._gram[-1, -1] - 2.0 * right @ x + x @ matrix @ x
        return LinearFit(tuple(signatures), strengths, self._left(left))

    def bic(self, fit: LinearFit | None) -> float:
        """Bayesian information criterion (Schwarz, Ann. Stat. 6, 1978) of a
        fit, None: of the nominal twin; the variance is fitted.
        """
        n = self.case.count
        misfit = self.misfit if fit is None else fit.misfit
        free = 0 if fit is None else fit.num_free
        return n * np.log(1.0 + misfit) + free * np.log(n)

    def subject_beside(self, fit: LinearFit) -> np.ndarray:
        """Values of the subject beside a fit's effects (s,)."""
        step = self._along[:, -1] + self._along[:, fit.places] @ fit.vector
        subject = self.case.subject.copy()
        subject[self._seen] -= self.case.scales[self._seen] * step
        return subject

    def along_beside(self, fit: LinearFit | None) -> np.ndarray:
        """Product of each column with what a fit leaves (n,); None: with what
        the nominal twin leaves.
        """
        if fit is None:
            return self._gram[:-1, -1]
        return self._gram[:-1, -1] + self._gram[:-1, fit.places] @ fit.vector

    def explains(self, fit: LinearFit) -> bool:
        """Whether it takes a good part of the gap's amplitude."""
        left = max(fit.misfit, 0.0) / max(self.misfit, 1e-12)
        return np.sqrt(left) <= UNEXPLAINED


def _solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of a symmetric system, by its scaled eigenvectors: what is a
    copy of something else takes nothing.
    """
    size = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, ways = np.linalg.eigh(matrix * np.outer(size, size))
    values = np.maximum(values, _RIDGE * values[-1])
    scaled = (right.T * size).T
    return ((ways / values) @ (ways.T @ scaled)).T.dot(np.diag(size)).T
