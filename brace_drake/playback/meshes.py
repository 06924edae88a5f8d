"""Surfaces of rings and torso as triangles, turned about z."""

from __future__ import annotations

import numpy as np
from trimesh.creation import revolve


def make_ring_mesh(
    half_axes: np.ndarray, radial: float, vertical: float
) -> tuple[np.ndarray, np.ndarray]:
    """A ring of elliptic section whose outer edge has the given half axes.

    Args:
        half_axes: Of the outer edge, x and y (2,), m.
        radial, vertical: Half axes of the section, m; the first along x.

    Returns:
        Vertices (3, n), m; triangles (3, m), seen from outside anticlockwise.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, 13)
    radius = half_axes[0] + radial * (np.cos(turn) - 1.0)
    section = np.column_stack([radius, vertical * np.sin(turn)])
    return _turn(section, 96, [1.0, half_axes[1] / half_axes[0], 1.0])


def make_torso_mesh(
    half_width: float, half_depth: float, bottom: float, top: float
) -> tuple[np.ndarray, np.ndarray]:
    """A trunk: an elliptic cylinder along z with rounded ends.

    Args:
        half_width: Along y, where pads press, m.
        half_depth: Along x, m.
        bottom, top: z of its ends, m.

    Returns:
        As `make_ring_mesh`.
    """
    cap = 0.35 * half_depth
    turn = np.linspace(0.0, 0.5 * np.pi, 8)
    # Radius over z: a quarter of an ellipse at either end.
    scale = 1.0 - 0.3 * (1.0 - np.sin(turn))
    low, high = bottom + cap * (1.0 - np.cos(turn)), top - cap
    z = [bottom, *low, *(high + cap * np.cos(turn))[::-1], top]
    radius = [0.0, *scale, *scale[::-1], 0.0]
    side = np.column_stack([radius, z])
    return _turn(side, 180, [half_depth, half_width, 1.0])


def _turn(line: np.ndarray, sections: int, scale: list[float]):
    """The surface of a line (n, 2) of radius and z, turned and stretched."""
    mesh = revolve(line, sections=sections)
    mesh.apply_scale(scale)
    return mesh.vertices.T.copy(), mesh.faces.T.copy()
