"""Meshes as text: tetrahedra as legacy VTK, surfaces as Wavefront OBJ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from brace_drake.core.errors import TorsoError
from brace_drake.torso.solid import Solid, make_solid

_TETRAHEDRON = 10  # VTK's number of that cell


def vtk_text(solid: Solid) -> str:
    """The solid as Drake reads it: ASCII, an unstructured grid, m."""
    points, cells = solid.vertices, solid.tetrahedra
    lines = [
        "# vtk DataFile Version 3.0",
        "torso in frame T, m",
        "ASCII",
        "DATASET UNSTRUCTURED_GRID",
        f"POINTS {len(points)} double",
        *(f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in points),
        f"CELLS {len(cells)} {5 * len(cells)}",
        *(f"4 {a} {b} {c} {d}" for a, b, c, d in cells),
        f"CELL_TYPES {len(cells)}",
        *[str(_TETRAHEDRON)] * len(cells),
    ]
    return "\n".join(lines) + "\n"


def obj_text(vertices: np.ndarray, triangles: np.ndarray) -> str:
    """A surface of triangles, m."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in np.asarray(triangles) + 1]
    return "\n".join(lines) + "\n"


def LoadSolid(path: str | Path) -> Solid:
    """Reads what `vtk_text` writes.

    Raises:
        TorsoError: It is not such a file.
    """
    path = Path(path)
    try:
        words = iter(path.read_text(encoding="utf-8").split())
        count = int(_after(words, "POINTS"))
        next(words)
        points = [float(next(words)) for _ in range(3 * count)]
        count = int(_after(words, "CELLS"))
        next(words)
        cells = [int(next(words)) for _ in range(5 * count)]
    except (OSError, ValueError, StopIteration, RuntimeError) as error:
        raise TorsoError(f"{path}: no tetrahedra in VTK: {error}") from error
    cells = np.array(cells, dtype=int).reshape(-1, 5)
    if np.any(cells[:, 0] != 4):
        raise TorsoError(f"{path}: a cell is no tetrahedron; allowed: 4 nodes")
    return make_solid(np.array(points).reshape(-1, 3), cells[:, 1:])


def LoadSurface(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of what `obj_text` writes.

    Raises:
        TorsoError: It is not such a file.
    """
    try:
        mesh = trimesh.load_mesh(path, process=False, maintain_order=True)
        return np.asarray(mesh.vertices), np.asarray(mesh.faces)
    # What trimesh raises on a broken file is not foreseen.
    except Exception as error:
        raise TorsoError(f"{path}: no surface in OBJ: {error}") from error


def _after(words, name: str) -> str:
    for word in words:
        if word == name:
            return next(words)
    raise ValueError(f"{name} is missing")
