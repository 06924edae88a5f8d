"""What an effect of a typical size would leave in planned recordings.

The signature of an effect is the change of the weighted recording that it
makes, less what the subject's parameters take up of it:

    g = (1 - Q Q') (y(effect, phi + dphi) - y(nominal, phi)),

with Q a basis of dy / dphi. dphi is found in Gauss-Newton steps rather than
one, for what a change of the subject takes up entirely, such as a clearance
below the preload, would else leave its curvature behind as a false signature.
Two effects whose signatures are parallel cannot be told apart by these runs,
however long they last; |cos| of the angle between them says how nearly so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.design.planned import predict, subject_columns
from brace_drake.devices.replays import is_dithered
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.least_squares import beyond, orthonormal_basis

# Sizes at which a gap counts as one floor, and tries to find them.
_NEAR, _TRIES = 1.25, 12
# More alike parameters than this are drawn, with this seed, not all the same.
_ALIKE, _SEED = 3, 5
# Gauss-Newton steps of the subject at most, and relative changes of it that
# are none.
_REFITS, _SETTLED = 4, 2e-3
# Subject parameters that the runs do not show, relative to what they do.
_COPY = 1e-8
# Differences by an effect's parameter, relative to its value.
_STEP = 0.05


@dataclass(frozen=True)
class Signature:
    """An effect at the size at which it leaves about one floor.

    Attributes:
        effect: The card.
        values: Its parameters at that size.
        vector: The signature (rows,), in floors.
        rms: Its root mean square, 1 where the limits allow it.
        columns: Sensitivities to the continuous parameters, subject projected
            out (rows, n); None for parameters by the dozen.
    """

    effect: Effect
    values: np.ndarray
    vector: np.ndarray
    rms: float
    columns: np.ndarray | None

    @property
    def norm(self) -> float:
        """Length of the signature, in standard deviations of the noise."""
        return float(np.linalg.norm(self.vector))


class SignatureMaker:
    """Signatures by planned runs, for a subject.

    Args:
        evaluator: Over planned runs.
        subject: Values of the subject's parameters.
    """

    def __init__(self, evaluator: Evaluator, subject: np.ndarray):
        self._evaluator, self._subject = evaluator, subject
        parts = subject_columns(evaluator, subject)
        self.subject_columns = np.concatenate(parts)
        self._basis = orthonormal_basis(self.subject_columns)
        self._inverse = np.linalg.pinv(self.subject_columns, _COPY)
        parameters = evaluator.twin.subject
        self._units = np.array([p.unit_step for p in parameters])
        self._lower = np.array([p.lower for p in parameters])
        self._upper = np.array([p.upper for p in parameters])
        self._nominal: dict[bool, np.ndarray] = {}

    def make(self, effect: Effect) -> Signature | None:
        """The signature of an effect; None where its twin breaks down."""
        at = sizes_of(effect)
        seen: dict[float, tuple | None] = {}

        def rms(size: float) -> float:
            seen[size] = self._refit(effect, at(size))
            if seen[size] is None:
                return np.inf
            return self._rms(seen[size][0])

        size = size_of_one_floor(rms, largest_size(effect, at))
        if seen[size] is None:
            return None
        vector, subject = seen[size]
        columns = self._columns(effect, at(size), vector, subject)
        return Signature(effect, at(size), vector, self._rms(vector), columns)

    def _rms(self, vector: np.ndarray) -> float:
        return float(np.sqrt(vector @ vector / self._evaluator.count))

    def _refit(self, effect, values):
        """Signature, and the subject that takes up most; None if broken."""
        subject, best = self._subject, None
        for _ in range(_REFITS):
            (change,) = self._changes(effect, [values], subject)
            if change is None:
                break
            vector = beyond(change, self._basis)
            if best is not None and vector @ vector > best[0] @ best[0]:
                break
            best = vector, subject
            taken = self._inverse @ change
            if np.abs(taken).max() < _SETTLED:
                break
            subject = np.clip(
                subject - taken * self._units, self._lower, self._upper
            )
        return best

    def _columns(self, effect, values, vector, subject) -> np.ndarray | None:
        if effect.spread is not None:
            return None
        steps, points = [], []
        for i in np.flatnonzero(effect.is_continuous):
            parameter, point = effect.parameters[i], values.copy()
            step = _STEP * (abs(values[i]) or parameter.typical)
            if values[i] + step > parameter.upper:
                step = -step
            point[i] += step
            steps.append(step)
            points.append(point)
        moved = self._changes(effect, points, subject)
        return np.column_stack(
            [
                np.zeros_like(vector)
                if m is None
                else (beyond(m, self._basis) - vector) / step
                for m, step in zip(moved, steps, strict=True)
            ]
        )

    def _changes(self, effect, points, subject) -> list[np.ndarray | None]:
        """What an effect and a subject change in the weighted recordings."""
        dithered = is_dithered(self._evaluator.twin, [(effect, ())])
        if dithered not in self._nominal:
            (parts,) = predict(self._evaluator, [(self._subject, ())], dithered)
            self._nominal[dithered] = np.concatenate(parts)
        found = predict(
            self._evaluator,
            [(subject, [(effect, values)]) for values in points],
            dithered,
        )
        nominal = self._nominal[dithered]
        return [
            None
            if any(p is None for p in parts)
            else np.concatenate(parts) - nominal
            for parts in found
        ]


def is_strength(effect: Effect, i: int) -> bool:
    """Whether a parameter makes its effect vanish, and is no time constant."""
    parameter = effect.parameters[i]
    if parameter.choices or parameter.off is None:
        return False
    return i == 0 or parameter.unit != "s" or effect.parameters[0].unit == "s"


def sizes_of(effect: Effect) -> Callable[[float], np.ndarray]:
    """Parameters of an effect by its size, 0 for none and 1 for the starts.

    Strengths grow with the size; shapes stay at their starts, choices at the
    one that is nearest to no effect.
    """
    shape = np.array(
        [
            (p.off if p.off in p.choices else p.choices[0])
            if p.choices
            else p.starts[len(p.starts) // 2]
            for p in effect.parameters
        ]
    )
    strong = [i for i in range(len(shape)) if is_strength(effect, i)]
    draws = np.ones(len(strong))
    if len(strong) > _ALIKE:
        draws = np.random.default_rng(_SEED).standard_normal(len(strong))
    off = np.array([effect.parameters[i].off for i in strong])
    full = np.array([shape[i] or effect.parameters[i].typical for i in strong])

    def at(size: float) -> np.ndarray:
        values = shape.copy()
        values[strong] = off + size * draws * (full - off)
        return values

    return at


def largest_size(effect: Effect, at: Callable[[float], np.ndarray]) -> float:
    """The largest size that keeps all parameters within their limits."""
    base, change = at(0.0), at(1.0) - at(0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(
            change > 0.0,
            (effect.upper - base) / change,
            (effect.lower - base) / change,
        )
    return float(np.min(room[change != 0.0], initial=np.inf))


def size_of_one_floor(rms: Callable[[float], float], largest: float) -> float:
    """The size at which a gap is about 1, the largest where it stays below.

    Regula falsi in logarithms, where the gap grows like a power of the size,
    else halves of the bracket; ends within a quarter.

    Args:
        rms: Gap by size, growing.
        largest: Size that is allowed.

    Returns:
        A size that `rms` was asked for last or before.
    """
    low, size = (0.0, 0.0), min(1.0, largest)
    high, best = None, None
    for _ in range(_TRIES):
        found = rms(size)
        error = abs(np.log(found)) if found > 0.0 else np.inf
        if best is None or error < best[0]:
            best = error, size
        if error < np.log(_NEAR) or (found < 1.0 and size >= largest):
            break
        if found > 1.0:
            high = size, found
        else:
            low = size, found
        size = _next_size(low, high, largest)
    return best[1]


def _next_size(low, high, largest: float) -> float:
    if high is None:
        grow = 1.0 / low[1] if low[1] > 0.0 else 4.0
        return min(largest, low[0] * min(max(1.05 * grow, 1.5), 100.0))
    if low[0] == 0.0 and np.isfinite(high[1]):
        return high[0] * max(0.9 / high[1], 1e-3)
    if low[1] > 0.0 and np.isfinite(high[1]):
        share = -np.log(low[1]) / np.log(high[1] / low[1])
        share = min(max(share, 0.1), 0.9)
        return low[0] * (high[0] / low[0]) ** share
    return 0.5 * (low[0] + high[0])


def cosines(signatures: Sequence[Signature]) -> np.ndarray:
    """|cos| of the angles between signatures (n, n)."""
    if not signatures:
        return np.zeros((0, 0))
    units = np.column_stack([s.vector / (s.norm or 1.0) for s in signatures])
    return np.abs(units.T @ units)
