"""Makes the torso samples of tests/data/torso.

python tools/make_torso_samples.py [--out FOLDER] [--seed N]

girl13.obj is the surface of diagrams/torso_girl13.measures.yaml. scan.ply is
that torso as a scanner would give it: triangles of all sizes, 0.4 mm of noise,
arms cut off at the shoulders and the stumps closed; in mm, y to the front, x to
the patient's right, its origin on the floor.
"""

import argparse
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import Delaunay

from brace_drake.core.resources import scenario_path
from brace_drake.torso.fitted import loft_surface
from brace_drake.torso.loft import loft_centre, loft_points
from brace_drake.torso.measures import LoadMeasures, make_parametric_loft
from brace_drake.torso.meshes import obj_text
from brace_drake.torso.solid import surface_volume

FOLDER = Path(__file__).resolve().parents[1] / "tests" / "data" / "torso"
NOISE = 0.0004  # m, one standard deviation, along the ray from the axis
POINTS = 2600
T7_ABOVE_FLOOR = 1184.0  # mm, ANSUR II small women: iliac crest 949 + 235
ARM_HEIGHT, ARM_RADIUS, ARM_REACH = 0.05, 0.04, 0.012  # m, of the stumps


def make_scan(loft, seed):
    """Vertices in T, m, and outward triangles of a scan-like torso."""
    random = np.random.default_rng(seed)
    low, high = loft.heights[[0, -1]]
    # Points as the camera saw them: dense in front, sparse at the sides.
    share = random.random(POINTS)
    turn = 2.0 * np.pi * share + 0.5 * np.sin(2.0 * np.pi * share)
    height = low + (high - low) * random.random(POINTS)
    # Both ends have a regular rim, so that the caps close.
    rim = 2.0 * np.pi * np.arange(64) / 64
    turn = np.concatenate([turn, rim, rim])
    height = np.concatenate([height, np.full(64, low), np.full(64, high)])
    points = loft_points(loft, turn, height)
    ray = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(len(turn))])
    stump = ARM_REACH * (np.abs(np.sin(turn)) > 0.8)
    away = (height - ARM_HEIGHT) ** 2 + points[:, 0] ** 2
    stump = stump * np.exp(-0.5 * away / (0.6 * ARM_RADIUS) ** 2)
    stump[POINTS:] = 0.0
    noise = NOISE * random.standard_normal(len(turn))
    points += (stump + noise)[:, None] * ray
    triangles = _around(turn, height)
    return _close(loft, points, triangles, (low, high))


def _around(turn, height):
    """Delaunay triangles on the unrolled trunk, closed around."""
    count = len(turn)
    # Copies on both sides; triangles whose middle is in the first turn.
    copies = [
        np.column_stack([turn + k * 2 * np.pi, 6 * height]) for k in (-1, 0, 1)
    ]
    mesh = Delaunay(np.concatenate(copies))
    middle = mesh.points[mesh.simplices].mean(axis=1)[:, 0]
    triangles = mesh.simplices[(middle >= 0) & (middle < 2 * np.pi)]
    a, b, c = (mesh.points[triangles[:, i]] for i in range(3))
    # Unrolled with the turn to the right, outward is counter-clockwise.
    cross = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    keep = np.abs(cross) > 1e-12
    triangles = np.where(cross[:, None] > 0, triangles, triangles[:, ::-1])
    return triangles[keep] % count


def _close(loft, points, triangles, ends):
    """Flat caps from the rims to the centres of the ends."""
    first = len(points) - 128
    centres = [[*loft_centre(loft, z), z] for z in ends]
    points = np.concatenate([points, centres])
    j, after = np.arange(64), (np.arange(64) + 1) % 64
    low, high = first + j, first + 64 + j
    bottom = [first + after, low, np.full(64, len(points) - 2)]
    top = [high, first + 64 + after, np.full(64, len(points) - 1)]
    caps = [np.column_stack(bottom), np.column_stack(top)]
    return points, np.concatenate([triangles, *caps])


def as_scanner_sees(points):
    """From T, m, to the scanner's frame, mm: y front, x right, z from floor."""
    turned = np.column_stack([-points[:, 1], points[:, 0], points[:, 2]])
    return 1e3 * turned + [0.0, 0.0, T7_ABOVE_FLOOR]


def main():
    """Writes both samples."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=FOLDER)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    measures = LoadMeasures(scenario_path("torso_girl13.measures.yaml"))
    coarse = make_parametric_loft(measures, 41, 48)
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "girl13.obj").write_text(obj_text(*loft_surface(coarse)))
    points, triangles = make_scan(make_parametric_loft(measures), args.seed)
    print(
        f"{len(triangles)} triangles, {surface_volume(points, triangles)} m^3"
    )
    scan = trimesh.Trimesh(
        as_scanner_sees(points).astype(np.float32), triangles, process=False
    )
    scan.export(args.out / "scan.ply")


if __name__ == "__main__":
    main()
