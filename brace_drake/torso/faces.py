"""The face of a pad: cut out of the torso's surface, or a few points of it.

A face is the patch of the surface behind the pad's window, as a brace is shaped
on a scan: with no preload it touches everywhere and presses nowhere.

Drake's contact costs about as much as it has faces: a pad's whole face on the
torso's facets has more than a hundred. The force of an elastic foundation is
an integral over the pad; a pad of points takes Gauss-Legendre's sum for it.
Each of its points is a speck, a triangle so small that it lies on one facet, as
large as the point's weight, and the foundation is stiffer by what specks are
smaller than their pad. Pressures that Drake shows are larger by as much; forces
are those of the pad.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from trimesh.intersections import slice_faces_plane

from brace_drake.core.errors import TorsoError
from brace_drake.torso.pads import Pad, PadPlace
from brace_drake.torso.solid import Solid

# What lies deeper behind a window, m, is the torso's other side.
_BEHIND = 0.1
# Triangles below this are what rounding leaves of neighbours, m^2.
_SLIVER = 1e-8
# A node this little beyond a pad's edge, m, is on it.
_ON_EDGE = 1e-7
# How far a face may be from its window, as a part of it.
_WINDOW = 0.01
# All specks of a pad over its face.
SHARE = 1e-4
_CORNERS = 2.0 * np.pi * np.arange(3) / 3.0


def make_pads(solid: Solid, places: Sequence[PadPlace]) -> list[Pad]:
    """Cuts the pads' faces out of the surface of a solid.

    Raises:
        TorsoError: A pad's window is not all over the torso's side.
    """
    return [_cut_face(solid, place) for place in places]


def _cut_face(solid: Solid, place: PadPlace) -> Pad:
    normals = trimesh.triangles.cross(solid.vertices[solid.triangles])
    vertices = (solid.vertices - place.p_TP) @ place.axes.T
    depths = np.abs(vertices[solid.triangles, 2]).max(axis=1)
    near = (normals @ place.normal > 0.0) & (depths < _BEHIND)
    triangles = solid.triangles[near]
    for axis in (0, 1):
        for sign in (1.0, -1.0):
            inward = np.zeros(3)
            inward[axis] = -sign
            edge = -(0.5 * place.size[axis] + _ON_EDGE) * inward
            vertices, triangles, _ = slice_faces_plane(
                vertices, triangles, inward, edge
            )
    # Turned over: the pad faces the torso.
    face = trimesh.Trimesh(vertices, triangles[:, ::-1], process=False)
    face.update_faces(face.area_faces > _SLIVER)
    face.merge_vertices(digits_vertex=8)
    in_T = face.vertices @ place.axes + place.p_TP
    pad = Pad(place, in_T, np.asarray(face.faces))
    window = float(np.sum(pad.area_vectors @ place.normal))
    whole = np.prod(place.size)
    if abs(window - whole) > _WINDOW * whole:
        raise TorsoError(
            f"pad {place.name} lies on {1e4 * window:.1f} cm^2 of the torso's"
            f" side; allowed: its whole window, {1e4 * whole:.1f}"
        )
    return pad


def make_point_pad(pad: Pad, across: int, up: int) -> Pad:
    """The pad with `across` times `up` specks as its face.

    Its effective area is SHARE of the whole face's.

    Raises:
        TorsoError: A point is not over the face.
    """
    place, vectors = pad.place, pad.area_vectors
    corners = ((pad.vertices - place.p_TP) @ place.axes.T)[pad.triangles]
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
    along = np.array(normals) @ place.normal
    scale = SHARE * pad.effective_area / np.sum(areas * along**2)
    vertices = [
        _speck(centre, normal, scale * area)
        for centre, normal, area in zip(centres, normals, areas, strict=True)
    ]
    triangles = np.arange(3 * len(areas)).reshape(-1, 3)
    return Pad(place, np.vstack(vertices), triangles)


def _find_triangle(corners: np.ndarray, at: np.ndarray, name: str):
    """The triangle over a point of the window, and shares of its corners."""
    flat = corners * [1.0, 1.0, 0.0]
    points = np.tile([*at, 0.0], (len(flat), 1))
    shares = trimesh.triangles.points_to_barycentric(flat, points)
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
