"""Meshes as text: tetrahedra as legacy VTK, surfaces as Wavefront OBJ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from brace_drake.core.errors import TorsoError
from brace_drake.core.reading import ReadBytes, check_file, decode, in_file
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
    with in_file(path, TorsoError):
        words = decode(ReadBytes(path)).split()
    try:
        points = _numbers_after("POINTS", words, 3, float)
        cells = _numbers_after("CELLS", words, 5, int)
    except (ValueError, IndexError, OverflowError) as error:
        raise TorsoError(
            f"{path}: no tetrahedra in VTK; allowed: what `brace-drake"
            " personalize` writes"
        ) from error
    if np.any(cells[:, 0] != 4):
        raise TorsoError(f"{path}: a cell is no tetrahedron; allowed: 4 nodes")
    return make_solid(points, cells[:, 1:])


def _numbers_after(name: str, words: list[str], width: int, kind: type):
    """The rows of `width` numbers that a keyword and their count announce."""
    start = words.index(name) + 3
    count = int(words[start - 2])
    numbers = words[start : start + width * count]
    return np.array(numbers, dtype=kind).reshape(count, width)


def LoadSurface(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of what `obj_text` writes.

    Raises:
        TorsoError: It is not such a file.
    """
    with in_file(path, TorsoError):
        check_file(path)
    try:
        mesh = trimesh.load_mesh(path, process=False, maintain_order=True)
        return np.asarray(mesh.vertices), np.asarray(mesh.faces)
    # On a broken file trimesh may raise any exception.
    except Exception as error:
        raise TorsoError(
            f"{path}: no surface in OBJ; allowed: what `brace-drake"
            " personalize` writes"
        ) from error
