"""From outlines to a solid of tetrahedra that Drake takes as compliant.

Every section has an axis node and closed rings of nodes around it: the outline,
below it rings at fixed depths (the shell, where pads press), and the core about
the axis. Two neighbouring sections and two neighbouring nodes of a ring bound
a wedge about the axis and, in the shell, bricks; a brick is two wedges, a wedge
three tetrahedra. Every quadrilateral face is cut by the diagonal at its
smallest node (Dompierre et al., 8th Int. Meshing Roundtable, 1999), so
neighbours fit.

Drake's pressure is linear in each tetrahedron, from 0 on the surface to
E depth / H at an inner node (H: the deepest one). The shell makes it E d / H
close below the surface, whatever the shape of the core. A layer of foundation
modulus κ = p / d, N/m^3, therefore needs E = κ H.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from brace_drake.core.errors import TorsoError

# A wedge's nodes turned so that the smallest comes first (Dompierre, table 2).
_TURNS = np.array(
    [
        [0, 1, 2, 3, 4, 5],
        [1, 2, 0, 4, 5, 3],
        [2, 0, 1, 5, 3, 4],
        [3, 5, 4, 0, 2, 1],
        [4, 3, 5, 1, 0, 2],
        [5, 4, 3, 2, 1, 0],
    ]
)
# Holds a node on its normal where the facets at it lie in one plane.
_FLAT = 1e-3
# As a part of its depth, how much nearer to one facet than to another a node
# may be.
_MISSED = 0.003
# To make a folded shell thinner; the last is 1e-3 of its depth.
_ATTEMPTS = 10


@dataclass(frozen=True)
class Solid:
    """A solid of tetrahedra and its closed surface, in T.

    Attributes:
        vertices: Of both (v, 3), m.
        tetrahedra: Of positive volume (t, 4), indices.
        triangles: Of the surface, outward (s, 3), indices.
    """

    vertices: np.ndarray
    tetrahedra: np.ndarray
    triangles: np.ndarray


def fill_outlines(
    outlines: np.ndarray, axis: np.ndarray, shell_depths=(0.02,)
) -> Solid:
    """Fills a stack of outlines with tetrahedra.

    Args:
        outlines: Closed, counter-clockwise from above (n, m, 3), m; each
            section lies at one height.
        axis: A point inside each section (n, 3), m.
        shell_depths: Of the inner rings below the surface, rising, m.

    Raises:
        TorsoError: A tetrahedron would be empty or inside out.
    """
    n, m = outlines.shape[:2]
    rings = len(shell_depths) + 1
    nodes = rings * m + 1
    low = _section_triangles(m, rings)
    wedges = np.concatenate([low, low + nodes], axis=1)
    wedges = wedges + nodes * np.arange(n - 1)[:, None, None]
    tetrahedra = split_wedges(wedges.reshape(-1, 6))
    moves = [_inward(outlines, axis, depth) for depth in shell_depths]
    part = np.ones((n, m, 1))
    for _ in range(_ATTEMPTS):
        stack = [outlines, *(outlines + part * move for move in moves)]
        stack.append(axis[:, None])
        vertices = np.concatenate(stack, axis=1).reshape(-1, 3)
        bad = ~(signed_volumes(vertices, tetrahedra) > 0.0)
        if not bad.any():
            break
        # Where the shell folds (necks, shoulders), it becomes thinner.
        section, place = np.divmod(np.unique(tetrahedra[bad]), nodes)
        inner = (place >= m) & (place < rings * m)
        part[section[inner], place[inner] % m] *= 0.5
    return make_solid(vertices, tetrahedra)


def make_solid(vertices: np.ndarray, tetrahedra: np.ndarray) -> Solid:
    """The solid of some tetrahedra, checked.

    Raises:
        TorsoError: One is empty or inside out; it names the first place.
    """
    volumes = signed_volumes(vertices, tetrahedra)
    # Written so that NaN is bad.
    bad = np.flatnonzero(~(volumes > 0.0))
    if len(bad):
        z = vertices[tetrahedra[bad[0]], 2].mean()
        raise TorsoError(
            f"{len(bad)} of {len(volumes)} tetrahedra are inside out, the first"
            f" at z = {z:.3f} m: neighbouring sections differ too much;"
            " allowed: 0"
        )
    return Solid(vertices, tetrahedra, boundary_triangles(tetrahedra))


def _inward(outlines: np.ndarray, axis: np.ndarray, depth: float) -> np.ndarray:
    """The way from each node of the outlines to `depth` below the surface.

    The mitred offset: a node moves to where it is as far from all facets that
    meet at it, by -depth o with n_f . o = 1 for their normals n_f. Where that
    leads too far (shoulders, ends), it moves less along the same line.
    """
    normals = _facet_normals(outlines)
    # The four facets around a node; the first and the last section have two.
    last = np.concatenate([normals, normals[-1:]])
    first = np.concatenate([normals[:1], normals])
    around = [last, np.roll(last, 1, 1), first, np.roll(first, 1, 1)]
    n = np.stack(around, axis=-2)
    # Within the section where that serves: lines that run along the edges of
    # pads then do so below the surface too.
    o = _solve_mitre(n * [1.0, 1.0, 0.0])
    missed = np.abs(np.sum(n * o[..., None, :], axis=-1) - 1.0).max(axis=-1)
    missed[[0, -1]] = 0.0
    o = np.where(missed[..., None] > _MISSED, _solve_mitre(n), o)
    move = depth * o
    room = 0.5 * np.linalg.norm(outlines - axis[:, None], axis=-1)
    across = np.maximum(np.linalg.norm(move[..., :2], axis=-1), 1e-12)
    gap = np.diff(axis[:, 2])
    gap = 0.4 * np.minimum(np.append(gap, gap[-1]), np.insert(gap, 0, gap[0]))
    up = np.maximum(np.abs(move[..., 2]), 1e-12)
    part = np.minimum(room / across, gap[:, None] / up)
    return -np.minimum(1.0, part)[..., None] * move


def _solve_mitre(n: np.ndarray) -> np.ndarray:
    """Least squares of n_f . o = 1 over the facets at each node (..., 3)."""
    gram = np.swapaxes(n, -1, -2) @ n + _FLAT * np.eye(3)
    return np.linalg.solve(gram, n.sum(axis=-2)[..., None])[..., 0]


def _facet_normals(outlines: np.ndarray) -> np.ndarray:
    """Unit normals of the facets between sections, outward (n - 1, m, 3)."""
    after = np.roll(outlines, -1, axis=1)
    normals = np.cross(
        after[1:] - outlines[:-1], outlines[1:] - after[:-1], axis=-1
    )
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    return normals / np.maximum(length, np.finfo(float).tiny)


def _section_triangles(m: int, rings: int) -> np.ndarray:
    """Triangles of a section, counter-clockwise from above."""
    j, after = np.arange(m), (np.arange(m) + 1) % m
    triangles = []
    for outer in range(0, (rings - 1) * m, m):
        inner = outer + m
        quads = [outer + j, outer + after, inner + after, inner + j]
        triangles.append(split_quads(np.column_stack(quads)))
    last = (rings - 1) * m
    core = [last + j, last + after, np.full(m, rings * m)]
    return np.concatenate([*triangles, np.column_stack(core)])


def split_quads(quads: np.ndarray) -> np.ndarray:
    """Two triangles of each quadrilateral, cut at its smallest node."""
    order = (np.argmin(quads, axis=1)[:, None] + np.arange(4)) % 4
    quads = np.take_along_axis(quads, order, axis=1)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def split_wedges(wedges: np.ndarray) -> np.ndarray:
    """Three tetrahedra of each wedge, shape (3 w, 4).

    Args:
        wedges: Low triangle, counter-clockwise from above, then the high one
            above it (w, 6).
    """
    order = _TURNS[np.argmin(wedges, axis=1)]
    w = np.take_along_axis(wedges, order, axis=1)
    # Two faces are cut at the smallest node; the third has its own smallest.
    one = np.minimum(w[:, 1], w[:, 5]) < np.minimum(w[:, 2], w[:, 4])
    one = one[:, None]
    first = np.where(one, w[:, [0, 1, 2, 5]], w[:, [0, 1, 2, 4]])
    second = np.where(one, w[:, [0, 1, 5, 4]], w[:, [0, 4, 2, 5]])
    return np.concatenate([first, second, w[:, [0, 4, 5, 3]]])


def signed_volumes(vertices: np.ndarray, tetrahedra: np.ndarray) -> np.ndarray:
    """Volumes, m^3, positive where v3 sees v0 v1 v2 run counter-clockwise."""
    a, b, c, d = (vertices[tetrahedra[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0


def boundary_triangles(tetrahedra: np.ndarray) -> np.ndarray:
    """Faces of one tetrahedron only, outward (s, 3)."""
    corners = ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1])
    faces = np.concatenate([tetrahedra[:, c] for c in corners])
    _, index, counts = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    return faces[np.sort(index[counts == 1])]


def surface_volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Volume inside a closed surface, positive where it faces outward, m^3."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", np.cross(a, b), c) / 6.0)


def deepest(solid: Solid) -> float:
    """Distance of the deepest inner node from the surface, m."""
    triangles = solid.vertices[solid.triangles]
    on_surface = np.unique(solid.triangles)
    inner = np.setdiff1d(np.arange(len(solid.vertices)), on_surface)
    # The nearest node of the surface bounds the distance from above.
    tree = cKDTree(solid.vertices[on_surface])
    bounds, _ = tree.query(solid.vertices[inner])
    best = 0.0
    for i in np.argsort(-bounds):
        if bounds[i] <= best:
            break
        point = np.broadcast_to(solid.vertices[inner[i]], (len(triangles), 3))
        nearest = trimesh.triangles.closest_point(triangles, point)
        distance = np.linalg.norm(nearest - point, axis=1).min()
        best = max(best, float(distance))
    return best
