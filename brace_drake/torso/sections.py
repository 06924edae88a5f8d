"""From a closed surface of triangles to a stack of sections.

A plane z = const cuts the triangles in pieces of the outline, each run through
counter-clockwise from above. Rays from the outline's centre of area must meet
it once each: then the section is star-shaped, the stack of sections is the
torso, and its solid follows without a general mesher. Where a ray meets the
outline more often there is a fold, an arm, or a surface through itself.
"""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import TorsoError
from brace_drake.torso.loft import Loft
from brace_drake.torso.solid import surface_volume

# Ends of a scan that are left out, as a part of its height: caps are not flat.
_MARGIN = 0.004
# How far the stack's volume may be from the surface's.
_VOLUME = 0.02


def cut_sections(
    vertices: np.ndarray,
    triangles: np.ndarray,
    source: str,
    sections: int = 161,
    around: int = 256,
) -> Loft:
    """The sections of a closed surface in T.

    Args:
        vertices: m. triangles: Outward. source: For messages.
        sections: Between the surface's lowest and highest point.
        around: Points of each outline.

    Raises:
        TorsoError: It is not such a stack; one line with height and number.
    """
    low, high = vertices[:, 2].min(), vertices[:, 2].max()
    margin = _MARGIN * (high - low)
    heights = np.linspace(low + margin, high - margin, sections)
    angles = np.arange(around) * (2.0 * np.pi / around)
    centres, radii = np.empty((sections, 2)), np.empty((sections, around))
    refused = {}
    for k, z in enumerate(heights):
        starts, ends = cut_plane(vertices, triangles, z)
        centres[k] = _centre(starts, ends)
        starts, ends = starts - centres[k], ends - centres[k]
        radii[k], times = _radii(starts, ends, angles)
        if times != 1:
            refused[float(z)] = times, starts, ends
    if refused:
        raise TorsoError(_refusal(refused, source))
    loft = Loft(heights, centres, angles, radii)
    _check_volume(loft, vertices, triangles, source)
    return loft


def cut_plane(
    vertices: np.ndarray, triangles: np.ndarray, z: float
) -> tuple[np.ndarray, np.ndarray]:
    """Pieces of the outline at a height: starts and ends (s, 2), m.

    Where an edge is cut does not depend on the triangle: pieces join exactly.
    """
    above = vertices[:, 2] >= z
    up = above[triangles]
    cut = triangles[(up.any(axis=1)) & ~(up.all(axis=1))]
    # The corner that is alone on its side first.
    alone = above[cut] == (above[cut].sum(axis=1) == 1)[:, None]
    first = np.argmax(alone, axis=1)
    order = (first[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(cut, order, axis=1).T
    one, two = _cut_edges(vertices, a, b, z), _cut_edges(vertices, a, c, z)
    # Outward triangles with the lone corner above are run from one to two.
    turned = above[a][:, None]
    return np.where(turned, one, two), np.where(turned, two, one)


def _cut_edges(vertices, a, b, z) -> np.ndarray:
    low, high = np.minimum(a, b), np.maximum(a, b)
    p, q = vertices[low], vertices[high]
    share = (z - p[:, 2]) / (q[:, 2] - p[:, 2])
    return p[:, :2] + share[:, None] * (q[:, :2] - p[:, :2])


def _centre(starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Centre of the area within the outline (2,), m."""
    shift = starts.mean(axis=0)
    a, b = starts - shift, ends - shift
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return shift + (twice @ (a + b)) / (3.0 * twice.sum())


def _radii(a, b, angles) -> tuple[np.ndarray, int]:
    """Where rays from the centre meet the outline, m.

    Returns:
        Radii, and how often the worst ray meets the outline: 1 is good.
    """
    ray = np.column_stack([np.cos(angles), np.sin(angles)])

    # Which side of the ray's line a joint is on is decided once for both of
    # its pieces: a ray through a joint meets exactly one of them.
    def left_of(p):
        return np.outer(ray[:, 0], p[:, 1]) >= np.outer(ray[:, 1], p[:, 0])

    from_left, to_left = left_of(a), left_of(b)
    d = b - a
    whole = a[:, 0] * d[:, 1] - a[:, 1] * d[:, 0]
    slope = np.outer(ray[:, 0], d[:, 1]) - np.outer(ray[:, 1], d[:, 0])
    passes = from_left != to_left
    with np.errstate(divide="ignore", invalid="ignore"):
        radii = np.where(passes, whole / slope, 0.0)
    met = radii > 0.0
    signed = np.sum(met & to_left, axis=1) - np.sum(met & from_left, axis=1)
    times = met.sum(axis=1)
    bad = (times != 1) | (signed != 1)
    if bad.any():
        # A single piece that runs backwards does not count.
        worst = int(times[bad].max())
        return np.zeros(len(angles)), worst if worst > 1 else 0
    return radii[np.arange(len(angles)), np.argmax(met, axis=1)], 1


def _refusal(refused: dict, source: str) -> str:
    """Why outlines are not star-shaped, by height: the gravest reason."""
    for z, (_, a, b) in refused.items():
        pairs = _count_crossings(a, b)
        if pairs:
            return (
                f"{source}: at z = {z:.3f} m the surface passes through itself,"
                f" {pairs} pairs of pieces of its outline cross; allowed: 0"
            )
    z, (times, _, _) = next(iter(refused.items()))
    return (
        f"{source}: at z = {z:.3f} m a ray from the section's centre meets the"
        f" surface {times} times; allowed: once, so cut off arms"
        " and head, and open folds"
    )


def _count_crossings(a: np.ndarray, b: np.ndarray) -> int:
    """Pairs of pieces that cross within both."""

    def side(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (
            q[..., 1] - p[..., 1]
        ) * (r[..., 0] - p[..., 0])

    a1, b1, a2, b2 = a[:, None], b[:, None], a[None], b[None]
    across_1 = side(a1, b1, a2) * side(a1, b1, b2) < 0.0
    across_2 = side(a2, b2, a1) * side(a2, b2, b1) < 0.0
    return int(np.sum(across_1 & across_2)) // 2


def _check_volume(loft, vertices, triangles, source) -> None:
    after = np.roll(loft.radii, -1, axis=1)
    areas = 0.5 * np.sum(loft.radii * after, axis=1) * np.sin(loft.angles[1])
    # The ends that were left out are as wide as the first and last section.
    reach = loft.heights[-1] - loft.heights[0]
    volume = np.trapezoid(areas, loft.heights)
    volume += (areas[0] + areas[-1]) * _MARGIN * reach
    whole = surface_volume(vertices, triangles)
    if abs(volume / whole - 1.0) > _VOLUME:
        raise TorsoError(
            f"{source}: its sections hold {volume / whole:.3f} of its volume;"
            f" allowed: 1 within {_VOLUME:g}"
        )
