"""Surfaces of rings and torso as triangles."""

from __future__ import annotations

import numpy as np


def make_ring_mesh(
    half_axes: np.ndarray, radial: float, vertical: float
) -> tuple[np.ndarray, np.ndarray]:
    """A ring of elliptic section whose outer edge has the given half axes.

    Args:
        half_axes: Of the outer edge, x and y (2,), m.
        radial, vertical: Half axes of the section, m.

    Returns:
        Vertices (3, n), m; triangles (3, m), seen from outside anticlockwise.
    """
    u, v = _grid(96, 12)
    x, y = (
        (axis - radial + radial * np.cos(v)) * f(u)
        for axis, f in zip(half_axes, (np.cos, np.sin), strict=True)
    )
    vertices = np.array([x, y, vertical * np.sin(v)]).reshape(3, -1)
    return vertices, _wrap(96, 12)


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
    z = np.concatenate(
        [
            bottom + cap * (1.0 - np.cos(turn)),
            (top - cap + cap * np.cos(turn))[::-1],
        ]
    )
    scale = np.concatenate([scale, scale[::-1]])
    n, m = 180, len(z)
    u = 2.0 * np.pi * np.arange(n) / n
    x = half_depth * np.outer(np.cos(u), scale)
    y = half_width * np.outer(np.sin(u), scale)
    sides = np.array([x, y, np.broadcast_to(z, x.shape)]).reshape(3, -1)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(m - 1)))
    a, b = m * i + j, m * ((i + 1) % n) + j
    sheet = np.hstack([[a, b, b + 1], [a, b + 1, a + 1]])
    ends = np.array([[0.0, 0.0], [0.0, 0.0], [bottom, top]])
    first, following = m * np.arange(n), m * ((np.arange(n) + 1) % n)
    low = np.array([following, first, np.full(n, n * m)])
    high = np.array([first, following, np.full(n, n * m + 1)])
    high[0:2] += m - 1
    return np.hstack([sides, ends]), np.hstack([sheet, low, high])


def _grid(n: int, m: int):
    u, v = (2.0 * np.pi * np.arange(k) / k for k in (n, m))
    return np.meshgrid(u, v, indexing="ij")


def _wrap(n: int, m: int) -> np.ndarray:
    """Triangles of an n x m grid of points closed in both directions."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(m)))
    a, b = m * i + j, m * ((i + 1) % n) + j
    c, d = m * i + (j + 1) % m, m * ((i + 1) % n) + (j + 1) % m
    return np.hstack([[a, b, d], [a, d, c]])
