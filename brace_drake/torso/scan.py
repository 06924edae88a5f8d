"""Scans of a torso: read, put into frame T, and refused where they are unfit.

Nothing is repaired in silence. Only corners that coincide are joined, which
STL files need. What has to be converted is said by the caller: the unit, the
axes, the origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from brace_drake.core.errors import TorsoError
from brace_drake.core.reading import check_file, in_file

FORMATS = (".obj", ".ply", ".stl")
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
# Least and largest size of a trunk without head and arms, from a child of six
# to a large man, m, and of breadth over depth.
_LIMITS = {"depth": (0.12, 0.5), "breadth": (0.16, 0.62), "height": (0.3, 0.9)}
_ASPECT = (0.8, 2.4)
# Largest coordinate, in the unit of the scan: a map's, in mm.
_FARTHEST = 1e9
_RANGE = f"numbers from {-_FARTHEST:g} to {_FARTHEST:g}"


@dataclass(frozen=True)
class ScanFrame:
    """How a scan's coordinates become those of T.

    Attributes:
        unit: Of the scan: m, cm, mm or in.
        origin: T's origin in the scan's coordinates and unit (3,).
        axes: The scan's axes that point to the patient's front, left and up,
            such as "+x+y+z".
    """

    unit: str = "m"
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axes: str = "+x+y+z"

    def rotation(self) -> np.ndarray:
        """R_TS (3, 3).

        Raises:
            TorsoError: The axes are not three right-handed ones.
        """
        rows = np.zeros((3, 3))
        signs, letters = self.axes[0::2], self.axes[1::2]
        if (
            len(self.axes) == 6
            and set(signs) <= set("+-")
            and sorted(letters) == ["x", "y", "z"]
        ):
            for i, (sign, letter) in enumerate(
                zip(signs, letters, strict=True)
            ):
                rows[i, "xyz".index(letter)] = 1.0 if sign == "+" else -1.0
        if np.linalg.det(rows) < 0.5:
            raise TorsoError(
                f"axes are {self.axes!r}; allowed: three signed letters for"
                " front, left and up that make a right-handed frame, such as"
                " '+x+y+z' or '-y+x+z'"
            )
        return rows


_AS_IS = ScanFrame()


def LoadScan(
    path: str | Path, frame: ScanFrame = _AS_IS
) -> tuple[np.ndarray, np.ndarray]:
    """Reads a scan and checks it.

    Returns:
        Vertices in T (v, 3), m, and outward triangles (t, 3).

    Raises:
        TorsoError: One line: the file, what was measured, what is allowed.
    """
    path = Path(path)
    if frame.unit not in UNITS:
        words = ", ".join(UNITS)
        raise TorsoError(f"unit is {frame.unit!r}; allowed: {words}")
    rotation = frame.rotation()
    # Written so that NaN fails.
    if not all(abs(value) <= _FARTHEST for value in frame.origin):
        told = " ".join(f"{value:g}" for value in frame.origin)
        raise TorsoError(f"origin is {told}; allowed: {_RANGE}")
    mesh = _read(path)
    moved = np.asarray(mesh.vertices) - np.asarray(frame.origin, dtype=float)
    mesh.vertices = UNITS[frame.unit] * moved @ rotation.T
    check_size(mesh.vertices, frame.unit, str(path))
    check_closed(mesh, str(path))
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def _read(path: Path) -> trimesh.Trimesh:
    if path.suffix.lower() not in FORMATS:
        words = ", ".join(FORMATS)
        found = f"ends in {path.suffix!r}" if path.suffix else "has no ending"
        raise TorsoError(
            f"{path}: {'is a folder' if path.is_dir() else found}; allowed: a"
            f" scan, {words}, or measures, *.yaml"
        )
    with in_file(path, TorsoError):
        check_file(path)
    try:
        mesh = trimesh.load(
            path, force="mesh", process=False, skip_materials=True
        )
    # On a broken file a reader of five formats may raise any exception, whose
    # words are of its own insides.
    except Exception as error:
        kind = path.suffix[1:].upper()
        raise TorsoError(
            f"{path}: cannot be read: {_broken(error)}; allowed: a whole {kind}"
            " file of triangles"
        ) from error
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0:
        raise TorsoError(f"{path}: 0 triangles; allowed: a closed surface")
    if mesh.vertices.ndim != 2 or mesh.vertices.shape[1] != 3:
        raise TorsoError(f"{path}: vertices have not three coordinates each")
    if not np.isfinite(mesh.vertices).all():
        bad = int(np.sum(~np.isfinite(mesh.vertices).all(axis=1)))
        raise TorsoError(f"{path}: {bad} vertices are not finite; allowed: 0")
    far = np.abs(mesh.vertices).max()
    if far > _FARTHEST:
        raise TorsoError(f"{path}: a vertex lies at {far:g}; allowed: {_RANGE}")
    corners, faces = len(mesh.vertices), mesh.faces
    if faces.ndim != 2 or faces.min() < 0 or faces.max() >= corners:
        raise TorsoError(
            f"{path}: a triangle names vertex {int(faces.max())}; allowed:"
            f" 0 to {corners - 1}"
        )
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return mesh


def _broken(error: Exception) -> str:
    """What is wrong with a file that a reader has given up on."""
    if isinstance(error, IndexError):
        return "it ends too early, or a face names a vertex that is not there"
    return "it is cut short, or its text or numbers are not of that form"


def check_size(vertices: np.ndarray, unit: str, source: str) -> None:
    """Refuses what has not the size of a torso, with a hint at the unit.

    Raises:
        TorsoError: It names the extent.
    """
    extents = np.ptp(vertices, axis=0)
    if not _fits(extents):
        measured = " x ".join(f"{e:.3g}" for e in extents)
        allowed = ", ".join(
            f"{name} {low:g} to {high:g}"
            for name, (low, high) in _LIMITS.items()
        )
        raise TorsoError(
            f"{source}: the scan measures {measured} m; allowed: {allowed} m"
            f"{_hint(extents, unit)}"
        )
    aspect = extents[1] / extents[0]
    if not _ASPECT[0] <= aspect <= _ASPECT[1]:
        raise TorsoError(
            f"{source}: breadth over depth is {aspect:.2f}; allowed:"
            f" {_ASPECT[0]:g} to {_ASPECT[1]:g}; see --axes"
        )


def _fits(extents) -> bool:
    limits = np.array(list(_LIMITS.values()))
    return bool(np.all((extents >= limits[:, 0]) & (extents <= limits[:, 1])))


def _hint(extents: np.ndarray, unit: str) -> str:
    for other, factor in UNITS.items():
        if other != unit and _fits(extents * factor / UNITS[unit]):
            return f"; in {other} it would fit: --unit {other}"
    order = np.argsort(extents)
    if _fits(extents[order]) and list(order) != [0, 1, 2]:
        return "; turned it would fit: see --axes"
    return ""


def check_closed(mesh: trimesh.Trimesh, source: str) -> None:
    """Refuses surfaces that do not bound one body.

    Raises:
        TorsoError: It names what is wrong and how much of it.
    """
    _, uses = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
    _, directed = np.unique(mesh.edges, axis=0, return_counts=True)
    for wrong, what in (
        (
            uses == 1,
            "the surface is open, {} edges belong to one triangle only;"
            " allowed: 0, so close its holes first",
        ),
        (uses > 2, "{} edges belong to more than two triangles; allowed: 0"),
        (
            directed > 1,
            "{} pairs of neighbouring triangles face opposite ways; allowed: 0",
        ),
    ):
        if wrong.any():
            raise TorsoError(f"{source}: {what.format(int(wrong.sum()))}")
    if mesh.body_count > 1:
        raise TorsoError(
            f"{source}: {mesh.body_count} separate bodies; allowed: 1"
        )
    if mesh.volume <= 0.0:
        raise TorsoError(
            f"{source}: the surface is inside out, its volume is"
            f" {mesh.volume:.4g} m^3; allowed: positive, so turn its triangles"
            " over"
        )
