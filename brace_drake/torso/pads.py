"""Pads that fit a torso: where they sit, and how stiff they are.

A pad sits where its ring's plane and mid-line (x = 0) meet the torso's side. It
is as wide as its size along its own horizontal direction and as tall along z.

Pushed in by d along its horizontal normal n, a face sinks by d n·m where its
own normal is m, so it meets the pressure κ d n·m and the force along n is

    F = κ d A_n,    A_n = ∫ (n·m)^2 dA,

with κ the foundation modulus, N/m^3. A_n is the pad's effective area.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import TorsoError
from brace_drake.torso.loft import Loft, side_point


@dataclass(frozen=True)
class PadPlace:
    """Where a pad sits.

    Attributes:
        ring: 1, 2, ... from the lowest moving ring.
        side: +1 for the patient's left (+y), -1 for the right.
        p_TP: Point of the surface in the middle of the pad (3,), m.
        normal: Horizontal unit vector out of the torso (3,).
        across: Horizontal unit vector along the pad towards the front (3,).
        size: Width along `across` and height along z, m.
    """

    ring: int
    side: int
    p_TP: np.ndarray
    normal: np.ndarray
    across: np.ndarray
    size: tuple[float, float]

    @property
    def axes(self) -> np.ndarray:
        """Rows across, up and along the normal (3, 3)."""
        return np.array([self.across, [0.0, 0.0, 1.0], self.normal])

    @property
    def name(self) -> str:
        """ring1_left and so on."""
        return f"ring{self.ring}_{'left' if self.side > 0 else 'right'}"


@dataclass(frozen=True)
class Pad:
    """A pad's place and its face.

    Attributes:
        place: Where it sits.
        vertices: Of its face, in T (v, 3), m.
        triangles: Facing the torso (t, 3), indices.
    """

    place: PadPlace
    vertices: np.ndarray
    triangles: np.ndarray

    @property
    def area_vectors(self) -> np.ndarray:
        """Of its triangles, out of the torso (t, 3), m^2."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        return 0.5 * np.cross(c - a, b - a)

    @property
    def surface_normal(self) -> np.ndarray:
        """Mean unit normal of the face, out of the torso (3,)."""
        total = self.area_vectors.sum(axis=0)
        return total / np.linalg.norm(total)

    @property
    def effective_area(self) -> float:
        """A_n of the module's docstring, m^2."""
        vectors = self.area_vectors
        along = vectors @ self.place.normal
        return float(np.sum(along**2 / np.linalg.norm(vectors, axis=1)))


def place_pads(
    loft: Loft, ring_heights: Sequence[float], size: tuple[float, float]
) -> list[PadPlace]:
    """A pad on the left and one on the right of each ring, bottom to top.

    Args:
        ring_heights: z in T of the moving rings at rest, m.
        size: Width and height of a pad, m.

    Raises:
        TorsoError: The torso does not reach as high or as low as the pads.
    """
    low, high = loft.heights[[0, -1]]
    places = []
    for ring, height in enumerate(ring_heights, start=1):
        ends = height - 0.5 * size[1], height + 0.5 * size[1]
        if ends[0] < low or ends[1] > high:
            raise TorsoError(
                f"the torso spans z = {low:.3f} to {high:.3f} m; the pads of"
                f" ring {ring} need {ends[0]:.3f} to {ends[1]:.3f} m"
            )
        for side in (1, -1):
            places.append(_place(loft, ring, height, side, size))
    return places


def _place(loft, ring, height, side, size) -> PadPlace:
    """The pad whose direction is the mean chord over its window."""
    chord = np.zeros(3)
    for z in height + np.linspace(-0.5, 0.5, 9) * size[1]:
        front = side_point(loft, z, side, 0.5 * size[0])
        chord += front - side_point(loft, z, side, -0.5 * size[0])
    across = np.array([chord[0], chord[1], 0.0])
    if across[0] <= 0.5 * np.linalg.norm(across):
        raise TorsoError(
            f"the torso's side at ring {ring} turns by more than 60 deg from"
            " the front-back direction; allowed: a side that a pad can face"
        )
    across /= np.linalg.norm(across)
    normal = side * np.array([-across[1], across[0], 0.0])
    point = side_point(loft, height, side)
    return PadPlace(ring, side, point, normal, across, tuple(size))
