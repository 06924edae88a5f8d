"""Numbers that are known to a tolerance: nuisance parameters, marginalised.

A number that is off by t_i deviations changes the weighted residual by the
column j_i t_i, and t has a unit normal prior. So the residual of a right twin
has the covariance I + J J', and whitened by its inverse root it is pure noise
again: nothing of it is taken for a gap. While small that costs nothing per
hypothesis (Kennedy and O'Hagan, Bayesian calibration of computer models, J. R.
Stat. Soc. B 63, 2001; Rasmussen and Williams, Gaussian Processes for Machine
Learning, section 2.7).

What bends, as anchors do where drives stick, is linearised where the numbers
are thought to be (Gauss-Newton in the numbers themselves): the twin is replayed
with them off by t0, and J t0 is taken off again, so that t stays around 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from weakref import WeakValueDictionary

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use

# Residuals that are whitened at once.
_AT_ONCE = 8

# From how far each number is off, SI units by name, to effects.
UsesOff = Callable[[Mapping[str, float]], tuple[Use, ...]]


@dataclass(frozen=True)
class LinearTolerances:
    """What numbers within their tolerances change of weighted residuals.

    Attributes:
        nuisances: The numbers, n of them.
        basis: Orthonormal directions that their changes span (rows, k).
        columns: Change by one deviation of each, in the basis (k, n).
        uses_off: Effects of numbers that are off; None where they are taken
            as they are.
        off: Deviations t0 at which that is linearised (n,); 0 without.
        whole: The same with the numbers that effects stand for.
        noise: Variance v of all else along the numbers, beside which their
            tolerances are weighed, see `devices.stretch`.
        root: (I + J J' / v)^(-1/2) in the basis (k, k).
        uses: Effects that put the numbers off by t0.
    """

    nuisances: tuple[Nuisance, ...]
    basis: np.ndarray
    columns: np.ndarray
    uses_off: UsesOff | None = field(default=None, repr=False, compare=False)
    off: np.ndarray | None = None
    whole: LinearTolerances | None = field(
        default=None, repr=False, compare=False
    )
    noise: float = 1.0
    root: np.ndarray = field(init=False)
    uses: tuple[Use, ...] = field(init=False, repr=False, compare=False)
    _coloured: np.ndarray = field(init=False)
    _parts: WeakValueDictionary[tuple[int, ...], LinearTolerances] = field(
        init=False, repr=False, compare=False
    )

    def __post_init__(self):
        squares, ways = np.linalg.eigh(self.columns @ self.columns.T)
        size = np.sqrt(1.0 + np.maximum(squares, 0.0) / self.noise)
        vars(self)["root"] = (ways / size) @ ways.T
        vars(self)["_coloured"] = (ways * size) @ ways.T
        vars(self)["uses"] = uses_within(
            self.nuisances, self.off, self.uses_off
        )
        self._forget_parts()

    def _forget_parts(self) -> None:
        # A part knows the whole: cycles of matrices would fill the memory.
        vars(self)["_parts"] = WeakValueDictionary()

    def __getstate__(self):
        return {k: v for k, v in vars(self).items() if k != "_parts"}

    def __setstate__(self, state):
        vars(self).update(state)
        self._forget_parts()

    def around_zero(self, residual: np.ndarray) -> np.ndarray:
        """A weighted residual (rows,) or (rows, m) of a twin with `uses`, as it
        were with all numbers at 0.
        """
        if self.off is None:
            return residual
        taken = self.basis @ (self.columns @ self.off)
        return (residual.T - taken).T

    def whiten(self, residual: np.ndarray) -> np.ndarray:
        """(I + J J' / v)^(-1/2) of a weighted residual (rows,) or (rows, m)."""
        along = self.basis.T @ residual
        return residual + self._spanned(self.root @ along - along)

    def whiten_in_place(self, residuals: Sequence[np.ndarray]) -> None:
        """`whiten` of several residuals (rows,) of a twin with `uses`.

        A few at once: alone, each would read the basis from memory anew, and
        all together they would stand in it twice.
        """
        for i in range(0, len(residuals), _AT_ONCE):
            few = residuals[i : i + _AT_ONCE]
            rows = self.whiten(self.around_zero(np.stack(few).T))
            for residual, white in zip(few, rows.T, strict=True):
                residual[:] = white

    def _spanned(self, along: np.ndarray) -> np.ndarray:
        """Vectors of the basis (k,) or (k, m) in all rows, column by column in
        memory.
        """
        return (along.T @ self.basis.T).T

    def whiten_pieces(
        self, residual: np.ndarray, ends: Sequence[int]
    ) -> np.ndarray:
        """`whiten` of each piece of a residual (rows,), zero elsewhere.

        Args:
            residual: Before.
            ends: Of the pieces, m of them.

        Returns:
            A column for each (rows, m).
        """
        pieces = [slice(*p) for p in zip([0, *ends[:-1]], ends, strict=True)]
        along = np.column_stack([self.basis[p].T @ residual[p] for p in pieces])
        out = self._spanned(self.root @ along - along)
        for k, p in enumerate(pieces):
            out[p, k] += residual[p]
        return out

    def colour(self, whitened: np.ndarray) -> np.ndarray:
        """The inverse of `whiten`."""
        along = self.basis.T @ whitened
        return whitened + self._spanned(self._coloured @ along - along)

    def from_whitened(self, other: LinearTolerances) -> np.ndarray:
        """T (k, k) of B T B' v, which is added to what others with the same
        basis B have whitened: as whitened by these.
        """
        return self.root @ other._coloured - np.eye(len(self.root))

    def along(self, whitened: np.ndarray) -> np.ndarray:
        """A residual in the basis (k,), of what it is after `whiten`."""
        return self._coloured @ (self.basis.T @ whitened)

    def estimate(self, along: np.ndarray, noise: float = 1.0) -> np.ndarray:
        """Posterior means t of the numbers, in their deviations (n,).

        Args:
            along: See `along`.
            noise: Variance of what else there is in the residual: 1 for noise
                alone, more where the twin leaves more.
        """
        slope = self.columns.T @ along
        gram = self.columns.T @ self.columns
        return -np.linalg.solve(gram + noise * np.eye(len(gram)), slope)

    def errors(self, noise: float = 1.0) -> np.ndarray:
        """Posterior standard deviations of the same (n,)."""
        gram = self.columns.T @ self.columns
        told = np.linalg.inv(gram / noise + np.eye(len(gram)))
        return np.sqrt(np.diag(told))

    def change(self, off: np.ndarray) -> float:
        """Squares that numbers which are off by t change (n,)."""
        along = self.columns @ off
        return float(along @ along)

    def tolerated(self, rows: np.ndarray) -> np.ndarray:
        """J' W of whitened rows: what tolerances add along them (n, m)."""
        return self.columns.T @ (self.root @ (self.basis.T @ rows))

    def beside(self, effects: Sequence[Effect]) -> LinearTolerances:
        """The same without the numbers that effects stand for themselves."""
        kept = tuple(
            i
            for i, n in enumerate(self.nuisances)
            if not any(n.is_of(e) for e in effects)
        )
        if len(kept) == len(self.nuisances):
            return self
        part = self._parts.get(kept)
        if part is None:
            part = self._parts[kept] = LinearTolerances(
                tuple(self.nuisances[i] for i in kept),
                self.basis,
                self.columns[:, list(kept)],
                self.uses_off,
                None if self.off is None else self.off[list(kept)],
                self.whole or self,
                self.noise,
            )
        return part

    def at(self, off: Sequence[float]) -> LinearTolerances:
        """The same with numbers put off by deviations t0 (n,), the columns
        kept.
        """
        whole = self.whole
        if whole is not None:
            mine = dict(zip(map(id, self.nuisances), off, strict=True))
            whole = whole.at([mine.get(id(n), 0.0) for n in whole.nuisances])
        return replace(self, off=able_off(self.nuisances, off), whole=whole)

    def beside_noise(self, noise: float) -> LinearTolerances:
        """The same weighed beside another variance of all else."""
        whole = self.whole and self.whole.beside_noise(noise)
        return replace(self, noise=noise, whole=whole)

    @cached_property
    def principal(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Directions in the basis, what they change, and the numbers that do:
        the singular value decomposition of `columns`.
        """
        return np.linalg.svd(self.columns, full_matrices=False)

    @property
    def at_zero(self) -> LinearTolerances:
        """The same without effects of the numbers, on their straight line."""
        return self if self.off is None else self._straight

    @cached_property
    def _straight(self) -> LinearTolerances:
        return replace(self, off=None)


def able_off(nuisances: Sequence[Nuisance], off: Sequence[float]) -> np.ndarray:
    """Deviations that numbers can be put off by: not beyond their limits. Dry
    friction stays at 0: it is an effect where it bends.
    """
    pairs = zip(nuisances, off, strict=True)
    return np.array(
        [0.0 if n.is_dithered else max(t, n.lower) for n, t in pairs]
    )


def uses_within(
    nuisances: Sequence[Nuisance],
    off: np.ndarray | None,
    uses_off: UsesOff | None,
) -> tuple[Use, ...]:
    """Effects of numbers that are off by so many deviations."""
    if off is None or uses_off is None or not np.any(off):
        return ()
    return uses_off(sizes_off(nuisances, off))


def sizes_off(
    nuisances: Sequence[Nuisance], off: Sequence[float]
) -> dict[str, float]:
    """SI units by the names of numbers, from deviations."""
    sizes: dict[str, float] = {}
    for nuisance, t in zip(nuisances, off, strict=True):
        size = float(t) * nuisance.deviation
        sizes[nuisance.name] = sizes.get(nuisance.name, 0.0) + size
    return sizes
