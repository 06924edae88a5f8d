"""A pad as a few points of its face, where contact is fast.

Drake's contact costs about as much as it has faces: a pad's whole face on the
torso's facets has more than a hundred. The force of an elastic foundation is
an integral over the pad; here it is Gauss-Legendre's sum for it. Each of its
points is a speck, a triangle so small that it lies on one facet, as large as
the point's weight, and the foundation is stiffer by what specks are smaller
than their pad. Pressures that Drake shows are larger by as much; forces are
those of the pad.
"""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import TorsoError
from brace_drake.torso.pads import Pad

# All specks of a pad over its face.
SHARE = 1e-4
_CORNERS = 2.0 * np.pi * np.arange(3) / 3.0


def make_point_pad(pad: Pad, across: int, up: int) -> Pad:
    """The pad with `across` times `up` specks as its face.

    Its effective area is SHARE of the whole face's.

    Raises:
        TorsoError: A point is not over the face.
    """
    place = pad.place
    axes = np.array([place.across, [0.0, 0.0, 1.0], place.normal])
    corners = ((pad.vertices - place.p_TP) @ axes.T)[pad.triangles]
    vectors = pad.area_vectors
    centres, normals, areas = [], [], []
    for u, wu in zip(*np.polynomial.legendre.leggauss(across), strict=True):
        for v, wv in zip(*np.polynomial.legendre.leggauss(up), strict=True):
            at = 0.5 * np.array([u * place.size[0], v * place.size[1]])
            i, shares = _find_triangle(corners, at, place.name)
            normal = vectors[i] / np.linalg.norm(vectors[i])
            centres.append(shares @ pad.vertices[pad.triangles[i]])
            normals.append(normal)
            # The window's part, laid on the facet.
            areas.append(wu * wv / (normal @ place.normal))
    normals, areas = np.array(normals), np.array(areas)
    along = normals @ place.normal
    areas *= SHARE * pad.effective_area / np.sum(areas * along**2)
    vertices = [
        _speck(*each) for each in zip(centres, normals, areas, strict=True)
    ]
    triangles = np.arange(3 * len(areas)).reshape(-1, 3)
    return Pad(place, np.vstack(vertices), triangles)


def _find_triangle(corners: np.ndarray, at: np.ndarray, name: str):
    """The triangle over a point of the window, and shares of its corners."""
    a, b, c = (corners[:, i, 0:2] for i in range(3))
    # Columns b - a and c - a times the shares of b and c are the way from a.
    sides = np.stack([b - a, c - a], axis=-1)
    of_b_and_c = np.linalg.solve(sides, (at - a)[..., None])[..., 0]
    shares = np.column_stack([1.0 - of_b_and_c.sum(axis=1), of_b_and_c])
    i = int(np.argmax(shares.min(axis=1)))
    if shares[i].min() < -1e-6:
        raise TorsoError(f"pad {name} has no face under one of its points")
    return i, shares[i]


def _speck(centre: np.ndarray, normal: np.ndarray, area: float) -> np.ndarray:
    """Corners (3, 3) of an equilateral triangle that faces along -normal."""
    first = np.cross([0.0, 0.0, 1.0], normal)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    radius = np.sqrt(4.0 * area / (3.0 * np.sqrt(3.0)))
    around = np.outer(np.cos(_CORNERS), first)
    around -= np.outer(np.sin(_CORNERS), second)
    return centre + radius * around
