"""Where a solid's nodes lie: lines along the pads' edges, coarser elsewhere.

Each facet under a whole pad costs contact faces at every step of the plant, so
the grid has as few as the resolution allows, and its lines run along the edges
of the pads: a facet cut by an edge would be two. Pads of points cost alike on
any grid: facets under them are smaller, so that points meet the true surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from brace_drake.torso.loft import Loft, loft_centre, loft_points, side_angle
from brace_drake.torso.pads import PadPlace

# Trunks are straighter along z than around: facets may be longer there.
_TALLER = 2.0
# Lines closer than this become one, m.
_CLOSE = 0.004


def make_grid(
    loft: Loft,
    places: Sequence[PadPlace],
    resolution: float,
    pad_resolution: float | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes on a loft, with lines along the pads' edges.

    Args:
        resolution: Largest width of a facet, m; those under pads may be
            taller.
        pad_resolution: The same under pads, and above, below and between
            them; None: as elsewhere.

    Returns:
        Outlines (n, m, 3) and the axis (n, 3), m.
    """
    if pad_resolution is None:
        pad_resolution = resolution
    heights = _heights(loft, places, resolution, pad_resolution)
    sectors = [_edges(loft, places, heights, side) for side in (1, -1)]
    (left_front, left_back), (right_front, right_back) = sectors
    turn = 2.0 * np.pi
    corners = [left_front, left_back, right_back + turn, right_front + turn]
    corners.append(left_front + turn)
    radius = np.sqrt(np.mean(loft.radii**2))
    blocks = []
    # Under the left pads, behind, under the right pads, in front.
    widths = pad_resolution, resolution, pad_resolution, resolution
    for (a, b), width in zip(pairwise(corners), widths, strict=True):
        count = max(1, int(np.ceil(np.mean(b - a) * radius / width)))
        share = np.arange(count) / count
        blocks.append(a[:, None] + (b - a)[:, None] * share)
    angles = np.concatenate(blocks, axis=1)
    outlines = loft_points(loft, angles, heights[:, None])
    return outlines, np.column_stack([loft_centre(loft, heights), heights])


def _heights(loft, places, resolution, pad_resolution) -> np.ndarray:
    """Heights of the sections: ends of the torso, of pads, and between."""
    spans = [p.p_TP[2] + np.array([-0.5, 0.5]) * p.size[1] for p in places]
    ends = [loft.heights[0], loft.heights[-1], *np.ravel(spans)]
    knots = []
    for z in sorted(ends):
        if not knots or z - knots[-1] > _CLOSE:
            knots.append(z)
    knots[-1] = loft.heights[-1]
    parts = []
    for a, b in pairwise(knots):
        under_pad = any(low < 0.5 * (a + b) < high for low, high in spans)
        spacing = _TALLER * pad_resolution if under_pad else resolution
        count = max(1, int(np.ceil((b - a) / spacing - 1e-9)))
        parts.append(np.linspace(a, b, count, endpoint=False))
    return np.append(np.concatenate(parts), knots[-1])


def _edges(loft, places, heights, side: int):
    """Angles of the pads' front and back edges at each height.

    Between pads their middle and direction are interpolated; above and below
    all pads the angles stay as they are at the last one.
    """
    own = sorted((p for p in places if p.side == side), key=lambda p: p.p_TP[2])
    z = [p.p_TP[2] for p in own]
    ends = [p.p_TP[2] + s * p.size[1] for p in own for s in (-0.5, 0.5)]
    heights = np.clip(heights, min(ends), max(ends))
    x, y, ax, ay, half = (
        np.interp(heights, z, values)
        for values in (
            [p.p_TP[0] for p in own],
            [p.p_TP[1] for p in own],
            [p.across[0] for p in own],
            [p.across[1] for p in own],
            [0.5 * p.size[0] for p in own],
        )
    )
    front, back = np.empty(len(heights)), np.empty(len(heights))
    for k, height in enumerate(heights):
        across = np.array([ax[k], ay[k]]) / np.hypot(ax[k], ay[k])
        point = np.array([x[k], y[k]])
        front[k], back[k] = (
            side_angle(loft, height, side, point, across, s * half[k])
            for s in (1.0, -1.0)
        )
    return front, back
