"""The numbers of a brace of n moving rings, as all compiled laws take them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import float64, types

from brace_drake.laws.control.brace_control import ESTIMATOR

_VECTOR, _MATRIX, _ANCHORS = float64[::1], float64[:, ::1], float64[:, :, ::1]


class BraceNumbers(NamedTuple):
    """Rings, legs, pads, torso, instruments, and what the controller knows.

    Rings and stages are counted bottom to top; the bench has n = 1. The
    plant's numbers may differ from those of the controller.

    Attributes:
        rest: Positions of the moving rings in W at rest (n, 3), m.
        lower, upper: Anchors of the legs (n, 6, 3), m, see `laws.stages`.
        viscous: Of each leg (6n,), N s/m.
        contact: Of each ring's pads stiffness, damping, friction,
            regularisation speed, pad offset, preload (n, 6); stiffness and
            damping 0: no pads.
        posture: K (3), D (3), K_r (3), D_r (3), lean (3): (15,), see
            `laws.posture`.
        ring: Mass, moments (3), weight of each ring (n, 5).
        torso: The same of the torso, which floats: weight 0 (5,).
        torso_rest: Position of the torso in W at rest (3,), m.
        start: Task coordinates of the rings at time 0 (6n,).
        torso_start: Displacement of the torso from rest at time 0, m, and its
            rotation vector, rad (6,).
        control: Rows of the controller's law (rows, 6n), see
            `laws.control.brace_control`.
        resolution: Of lengths, m, and forces, N (2,).
        noise_sigma: Of lengths (6n), forces (3n), marker (3).
    """

    rest: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    viscous: np.ndarray
    contact: np.ndarray
    posture: np.ndarray
    ring: np.ndarray
    torso: np.ndarray
    torso_rest: np.ndarray
    start: np.ndarray
    torso_start: np.ndarray
    control: np.ndarray
    resolution: np.ndarray
    noise_sigma: np.ndarray

    @property
    def num_stages(self) -> int:
        """How many rings move, n."""
        return len(self.rest)

    @property
    def reading_steps(self) -> np.ndarray:
        """To what each reading is rounded, as `noise_sigma`; 0: not at all."""
        n = self.num_stages
        return np.repeat([*self.resolution, 0.0], [6 * n, 3 * n, 3])

    @property
    def period(self) -> float:
        """Of a control tick, s."""
        return float(self.control[ESTIMATOR, 3])

    @property
    def force_law(self) -> np.ndarray:
        """What the forces on the bodies depend on, as one vector."""
        return np.concatenate([np.ravel(a) for a in self[:_NUM_OF_FORCES]])

    def with_force_law(self, law: np.ndarray) -> BraceNumbers:
        """These numbers with those of `force_law` seen in a vector."""
        arrays, at = [], 0
        for own in self[:_NUM_OF_FORCES]:
            arrays.append(law[at : at + own.size].reshape(own.shape))
            at += own.size
        return BraceNumbers(*arrays, *self[_NUM_OF_FORCES:])

    def with_stage_of(self, other: BraceNumbers, stage: int) -> BraceNumbers:
        """These numbers with those of one stage of another brace."""
        legs = slice(6 * stage, 6 * stage + 6)
        places = {
            **dict.fromkeys(("rest", "lower", "upper"), stage),
            **dict.fromkeys(("contact", "ring"), stage),
            **dict.fromkeys(("viscous", "start"), legs),
            "control": (slice(None), legs),
        }
        changed = {name: getattr(self, name).copy() for name in places}
        for name, place in places.items():
            changed[name][place] = getattr(other, name)[place]
        return self.with_changes(**changed)

    def with_changes(self, **arrays: np.ndarray) -> BraceNumbers:
        """A copy with some arrays replaced."""
        return self._replace(**arrays)


# The fields in front: forces depend on them alone.
_NUM_OF_FORCES = BraceNumbers._fields.index("start")

NUMBERS = types.NamedTuple(
    (
        _MATRIX, _ANCHORS, _ANCHORS, _VECTOR, _MATRIX, _VECTOR, _MATRIX,
        _VECTOR, _VECTOR, _VECTOR, _VECTOR, _MATRIX, _VECTOR, _VECTOR,
    ),
    BraceNumbers,
)  # fmt: skip
