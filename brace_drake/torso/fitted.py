"""A torso that is ready for a plant: surface, solid, pads, mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import SurfaceTriangle, TriangleSurfaceMesh
from pydrake.multibody.tree import CalcSpatialInertia, SpatialInertia

from brace_drake.core.errors import TorsoError
from brace_drake.torso.faces import make_pads
from brace_drake.torso.grid import make_grid
from brace_drake.torso.loft import Loft
from brace_drake.torso.pads import Pad, place_pads
from brace_drake.torso.solid import (
    Solid,
    deepest,
    fill_outlines,
    split_quads,
    surface_volume,
)

DENSITY = 1000.0  # kg/m^3, of the torso: section 2.3 of the paper
# Widest facet, m, and that under pads: what points of pads need for forces
# of single pads within 3 %, measured by tools/torso_contact.py.
RESOLUTION, PAD_RESOLUTION = 0.025, 0.005
# Depth of the shell, m: deeper than pads sink, and far from the axis.
SHELL = 0.02
# How far the solid's volume may be from the surface's.
_VOLUME = 0.02


@dataclass(frozen=True)
class FittedTorso:
    """A torso in T with the pads that fit it.

    Attributes:
        solid: Its tetrahedra, and the surface that pads meet.
        deepest: Of the solid's nodes, below its surface, m.
        pads: Of each ring, bottom to top, left then right.
        ring_heights: z in T of the rings at rest, m.
        inertia: M_TTo_T at the density of the paper.
    """

    solid: Solid
    deepest: float
    pads: list[Pad]
    ring_heights: np.ndarray
    inertia: SpatialInertia

    @property
    def mean_effective_area(self) -> float:
        """Of the pads, m^2."""
        return float(np.mean([pad.effective_area for pad in self.pads]))


def loft_surface(loft: Loft) -> tuple[np.ndarray, np.ndarray]:
    """The loft's closed surface: vertices (v, 3), m, triangles (t, 3)."""
    n, m = loft.radii.shape
    j, after = np.arange(m), (np.arange(m) + 1) % m
    low = m * np.arange(n - 1)[:, None]
    quads = [low + j, low + after, low + m + after, low + m + j]
    top = m * (n - 1)
    bottom_cap = [after, j, np.full(m, n * m)]
    top_cap = [top + j, top + after, np.full(m, n * m + 1)]
    triangles = [
        split_quads(np.stack(quads, axis=-1).reshape(-1, 4)),
        np.column_stack(bottom_cap),
        np.column_stack(top_cap),
    ]
    vertices = [loft.outlines.reshape(-1, 3), loft.axis[[0, -1]]]
    return np.concatenate(vertices), np.concatenate(triangles)


def calc_inertia(
    vertices: np.ndarray, triangles: np.ndarray, density: float = DENSITY
) -> SpatialInertia:
    """M_TTo_T of a homogeneous body within a closed surface in T."""
    mesh = TriangleSurfaceMesh(
        [SurfaceTriangle(*(int(i) for i in t)) for t in triangles],
        list(vertices),
    )
    return CalcSpatialInertia(mesh, density)


def fit_torso(
    loft: Loft,
    ring_heights: Sequence[float],
    pad_size: tuple[float, float],
    resolution: float = RESOLUTION,
    pad_resolution: float | None = None,
) -> FittedTorso:
    """Makes the solid of a torso and the pads that fit it.

    Args:
        ring_heights: z in T of the moving rings at rest, m.
        pad_size: Width and height of a pad, m.
        resolution: Largest width of a facet, m.
        pad_resolution: The same under pads; None: as elsewhere.

    Raises:
        TorsoError: The pads have no place on it, or its solid would be another
            shape than its surface.
    """
    places = place_pads(loft, ring_heights, pad_size)
    outlines, axis = make_grid(loft, places, resolution, pad_resolution)
    solid = fill_outlines(outlines, axis, (SHELL,))
    surface = loft_surface(loft)
    ratio = surface_volume(solid.vertices, solid.triangles) / surface_volume(
        *surface
    )
    if abs(ratio - 1.0) > _VOLUME:
        raise TorsoError(
            f"at a resolution of {resolution:g} m the solid has {ratio:.3f} of"
            f" the surface's volume; allowed: 1 within {_VOLUME:g}, so take a"
            " finer resolution"
        )
    return FittedTorso(
        solid,
        deepest(solid),
        make_pads(solid, places),
        np.asarray(ring_heights, dtype=float),
        calc_inertia(*surface),
    )
