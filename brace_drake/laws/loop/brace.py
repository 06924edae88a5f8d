"""A brace at a moment: what moves, what drives it, and places to work in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import boolean, float64, types

from brace_drake.laws import stages
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import matrix, vector
from brace_drake.laws.lanes.functions import every
from brace_drake.laws.numbers import BraceNumbers

# From rest or further, in sum over x, y, z of all bodies, m: flown apart.
_FAR = 1.0


class Brace(NamedTuple):
    """n rings, bottom to top, then the torso.

    Attributes:
        bodies: q, p of each, then [w; v] of each (13n + 13,): `poses` and `V`
            look at it.
        present: Whether the torso is there; whether the legs are forces, not
            bodies of their own (2,).
        poses: q, p of each body in W (n + 1, 7).
        V: [w; v] of each body in W (n + 1, 6).
        u: Leg commands that are held (6n,), N.
        readings: Lengths (6n), m, force of each ring on the torso (3n), N,
            displacement of the torso (3), m: (9n + 3,).
        F: [torque; force] on each body (n + 1, 6).
        f_T: Force of each ring on the torso (n, 3).
        lengths, rates, f: Of the legs (6n,); m, m/s, N.
        R: Orientation of each body (n + 1, 3, 3).
        p_WB: Lower anchors in W (n, 6, 3), m.
        J, J_L: Jacobians of the stages (n, 6, 6), see `laws.stages`.
        pad: A pad's contact (17,), see `forces.press_pads`.
        displacement: Of a body from rest, and its rotation vector (6,).
    """

    bodies: np.ndarray
    present: np.ndarray
    poses: np.ndarray
    V: np.ndarray
    u: np.ndarray
    readings: np.ndarray
    F: np.ndarray
    f_T: np.ndarray
    lengths: np.ndarray
    rates: np.ndarray
    f: np.ndarray
    R: np.ndarray
    p_WB: np.ndarray
    J: np.ndarray
    J_L: np.ndarray
    pad: np.ndarray
    displacement: np.ndarray


_array3 = float64[:, :, ::1]
BRACE = types.NamedTuple(
    (
        vector, boolean[::1], matrix, matrix, vector, vector, matrix, matrix,
        vector, vector, vector, _array3, _array3, _array3, _array3, vector,
        vector,
    ),
    Brace,
)  # fmt: skip


def make_brace(
    numbers: BraceNumbers, with_torso: bool, with_legs: bool = True
) -> Brace:
    """A brace at time 0, at rest, with no command yet."""
    n = numbers.num_stages
    bodies = np.zeros(13 * n + 13)
    brace = Brace(
        bodies=bodies,
        present=np.array([with_torso, with_legs]),
        poses=bodies[: 7 * n + 7].reshape((n + 1, 7)),
        V=bodies[7 * n + 7 :].reshape((n + 1, 6)),
        u=np.zeros(6 * n),
        readings=np.zeros(9 * n + 3),
        F=np.zeros((n + 1, 6)),
        f_T=np.zeros((n, 3)),
        lengths=np.zeros(6 * n),
        rates=np.zeros(6 * n),
        f=np.zeros(6 * n),
        R=np.zeros((n + 1, 3, 3)),
        p_WB=np.zeros((n, 6, 3)),
        J=np.zeros((n, 6, 6)),
        J_L=np.zeros((n, 6, 6)),
        pad=np.zeros(17),
        displacement=np.zeros(6),
    )
    stages.place_rings(numbers.start, numbers.rest, brace.poses[:n])
    stages.place_rings(
        numbers.torso_start, numbers.torso_rest[None], brace.poses[n:]
    )
    return brace


@compiled_law
def is_near(numbers, brace):
    """Whether all bodies, of all copies, are near their places at rest, as
    numbers.
    """
    n = numbers.rest.shape[0]
    p, rest = brace.poses[n, 4:7], numbers.torso_rest
    off = abs(p[0] - rest[0]) + abs(p[1] - rest[1]) + abs(p[2] - rest[2])
    for i in range(n):
        for c in range(3):
            off += abs(brace.poses[i, 4 + c] - numbers.rest[i, c])
    return every(off < _FAR)
