"""How deep a solid is: the length that Drake scales its pressure with.

Drake takes the pressure at an inner node as E depth / H, depth being the
node's distance from the surface and H the largest of them. A layer of
foundation modulus κ = p / d, N/m^3, therefore needs E = κ H.
"""

from __future__ import annotations

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from brace_drake.torso.solid import Solid


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
