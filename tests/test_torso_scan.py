"""Scans of torsos: what is read, what is refused, and what comes out."""

import tempfile
import unittest
from pathlib import Path

import numpy as np
import trimesh

from brace_drake.core.errors import TorsoError
from brace_drake.core.resources import scenario_path
from brace_drake.scenario.load import LoadScenario
from brace_drake.torso.fitted import calc_inertia, loft_surface
from brace_drake.torso.folder import LoadTorso, central_inertia
from brace_drake.torso.loft import half_widths, loft_radius, measure_trunk_bend
from brace_drake.torso.measures import (
    Curve,
    LoadMeasures,
    TorsoMeasures,
    make_parametric_loft,
)
from brace_drake.torso.meshes import LoadSurface
from brace_drake.torso.scan import LoadScan, ScanFrame
from brace_drake.torso.sections import cut_plane, cut_sections
from tests.commands import run_command

DATA = Path(__file__).parent / "data" / "torso"
SCAN = DATA / "scan.ply"
FRAME = ScanFrame("mm", (0.0, 0.0, 1184.0), "+y-x+z")
GIRL = scenario_path("torso_girl13.measures.yaml")


def small_loft(curve=None):
    return make_parametric_loft(TorsoMeasures(curve=curve or Curve()), 41, 48)


def area_of(starts, ends):
    return 0.5 * np.sum(starts[:, 0] * ends[:, 1] - starts[:, 1] * ends[:, 0])


class TestSections(unittest.TestCase):
    def test_a_plane_cuts_a_ball_in_a_circle(self):
        ball = trimesh.creation.icosphere(5, 0.2)
        for z in (-0.15, 0.0, 0.07):
            starts, ends = cut_plane(ball.vertices, ball.faces, z)
            # Closed: each end is a start, counter-clockwise.
            a = {tuple(p) for p in starts}
            self.assertEqual(a, {tuple(p) for p in ends})
            expected = np.pi * (0.2**2 - z**2)
            self.assertAlmostEqual(
                area_of(starts, ends) / expected, 1.0, delta=2e-3
            )

    def test_sections_of_a_surface_give_back_its_loft(self):
        curve = Curve(cobb_deg=30.0, axial_rotation_deg=-8.0)
        loft = make_parametric_loft(TorsoMeasures(curve=curve), 161, 128)
        found = cut_sections(*loft_surface(loft), "made")
        angles = np.linspace(0, 2 * np.pi, 100)
        for z in (-0.3, -0.09, 0.0, 0.06):
            want = loft_radius(loft, angles, np.full(100, z))
            have = loft_radius(found, angles, np.full(100, z))
            # Between its angles the one is the other's chord.
            self.assertLess(np.abs(want - have).max(), 2e-4)
        for z in (-0.09, 0.0, 0.06):
            np.testing.assert_allclose(
                half_widths(found, z), half_widths(loft, z), atol=2e-4
            )
        self.assertAlmostEqual(
            measure_trunk_bend(found), measure_trunk_bend(loft), delta=0.2
        )


class TestScan(unittest.TestCase):
    def test_the_sample_scan_is_the_girl_it_was_made_of(self):
        vertices, triangles = LoadScan(SCAN, FRAME)
        girl = make_parametric_loft(LoadMeasures(GIRL))
        scan = cut_sections(vertices, triangles, str(SCAN))
        ours, hers = (
            calc_inertia(*loft_surface(loft)) for loft in (scan, girl)
        )
        self.assertAlmostEqual(
            ours.get_mass() / hers.get_mass(), 1.0, delta=0.01
        )
        np.testing.assert_allclose(ours.get_com(), hers.get_com(), atol=0.002)
        for height in (-0.09, 0.0):
            np.testing.assert_allclose(
                half_widths(scan, height), half_widths(girl, height), atol=0.004
            )
        self.assertAlmostEqual(
            measure_trunk_bend(scan), measure_trunk_bend(girl), delta=2.0
        )

    def test_all_formats_and_units_give_the_same(self):
        vertices, triangles = loft_surface(small_loft())
        with tempfile.TemporaryDirectory() as name:
            for suffix, (unit, factor) in zip(
                (".obj", ".stl", ".ply", ".stl"),
                (("m", 1.0), ("mm", 1e3), ("cm", 100.0), ("in", 1 / 0.0254)),
                strict=True,
            ):
                path = Path(name) / f"torso{suffix}"
                trimesh.Trimesh(
                    factor * vertices, triangles, process=False
                ).export(path)
                found, faces = LoadScan(path, ScanFrame(unit))
                self.assertEqual(len(faces), len(triangles))
                self.assertEqual(len(found), len(vertices))
                np.testing.assert_allclose(
                    np.sort(found[:, 2]), np.sort(vertices[:, 2]), atol=1e-6
                )

    def test_axes_and_origin_turn_and_shift_a_scan(self):
        frame = ScanFrame("m", (1.0, 2.0, 3.0), "-y+x+z")
        # The scan's -y points to the front, its x to the left.
        np.testing.assert_array_equal(
            frame.rotation() @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]
        )
        np.testing.assert_array_equal(
            frame.rotation() @ [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]
        )
        for axes in ("+x+y-z", "+x+x+z", "xyz", "+a+y+z", ""):
            with self.assertRaisesRegex(TorsoError, "axes are .*allowed"):
                ScanFrame(axes=axes).rotation()


class TestRefusals(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.out = self.folder / "out"
        self.vertices, self.triangles = loft_surface(small_loft())

    def refused(self, vertices, triangles, *words, arguments=()):
        path = self.folder / "scan.ply"
        trimesh.Trimesh(vertices, triangles, process=False).export(path)
        self.refused_file(path, *words, arguments=arguments)

    def refused_file(self, path, *words, arguments=()):
        before = set(self.folder.rglob("*"))
        status, _, message = run_command(
            "personalize", path, "--out", self.out, *arguments
        )
        self.assertEqual(status, 2, message)
        self.assertEqual(len(message.strip().splitlines()), 1, message)
        self.assertNotIn("Traceback", message)
        for word in (path.name, *words):
            self.assertIn(word, message)
        self.assertEqual(set(self.folder.rglob("*")), before)

    def test_a_hole(self):
        self.refused(self.vertices, self.triangles[4:], "open", "allowed: 0")

    def test_inside_out(self):
        turned = self.triangles[:, ::-1]
        self.refused(self.vertices, turned, "inside out", "volume is -0.03")

    def test_triangles_that_face_opposite_ways(self):
        triangles = self.triangles.copy()
        triangles[10] = triangles[10, ::-1]
        self.refused(self.vertices, triangles, "3 pairs", "opposite ways")

    def test_wrong_units(self):
        for unit, factor in (("mm", 1e3), ("cm", 100.0), ("in", 39.37)):
            self.refused(
                factor * self.vertices, self.triangles, f"--unit {unit}"
            )
        self.refused(
            self.vertices,
            self.triangles,
            "0.3 to 0.9",
            arguments=["--unit", "mm"],
        )

    def test_an_unknown_unit(self):
        path = self.folder / "scan.ply"
        with self.assertRaisesRegex(TorsoError, "'ft'; allowed: m, cm, mm, in"):
            LoadScan(path, ScanFrame("ft"))

    def test_lying_down(self):
        self.refused(self.vertices[:, [2, 0, 1]], self.triangles, "--axes")

    def test_sideways(self):
        turned = self.vertices[:, [1, 0, 2]] * [1, -1, 1]
        self.refused(
            turned * [1.3, 0.9, 1.0], self.triangles, "breadth over depth"
        )

    def test_several_bodies(self):
        ball = trimesh.creation.icosphere(1, 0.02)
        vertices = np.concatenate([self.vertices, ball.vertices])
        triangles = np.concatenate(
            [self.triangles, ball.faces + len(self.vertices)]
        )
        self.refused(vertices, triangles, "2 separate bodies", "allowed: 1")

    def test_a_surface_through_itself(self):
        # A dent in the back that comes out at the front.
        away = (self.vertices[:, 2] + 0.15) ** 2 + self.vertices[:, 1] ** 2
        back = self.vertices[:, 0] < 0.0
        dent = np.where(back, np.exp(-0.5 * away / 0.03**2), 0.0)
        vertices = self.vertices + dent[:, None] * [0.32, 0.0, 0.0]
        self.refused(vertices, self.triangles, "through itself", "z = -0.1")

    def test_an_arm(self):
        # A loop of the side that hangs down and back over itself.
        z, y = self.vertices[:, 2], self.vertices[:, 1]
        bump = np.exp(-0.5 * ((z + 0.1) / 0.02) ** 2)
        bump = bump * np.exp(-0.5 * (self.vertices[:, 0] / 0.03) ** 2)
        bump = np.where(y > 0.0, bump, 0.0)
        vertices = self.vertices + np.outer(bump, [0.14, 0.12, 0.0])
        self.refused(vertices, self.triangles, "z = -0.1", "allowed: once")

    def test_a_trunk_that_does_not_reach_the_pads(self):
        path = self.folder / "scan.ply"
        low = self.vertices - [0.0, 0.0, 0.1]
        trimesh.Trimesh(low, self.triangles, process=False).export(path)
        status, _, errors = run_command("personalize", path, "--out", self.out)
        self.assertEqual(status, 2)
        self.assertIn("ring 3 need 0.020 to 0.100", errors)
        self.assertFalse(self.out.exists())

    def test_files_that_are_no_scans(self):
        path = self.folder / "scan.ply"
        path.write_text("not a mesh")
        self.refused_file(path, "cannot be read")
        path = self.folder / "scan.stl"
        path.write_bytes(b"\0" * 10)
        self.refused_file(path, "scan.stl")
        self.refused_file(self.folder / "none.obj", "cannot be read")
        path = self.folder / "scan.step"
        path.write_text("")
        self.refused_file(path, "'.step'; allowed: a scan, .obj, .ply, .stl")
        self.refused_file(self.folder, "is a folder; allowed: a scan")

    def test_a_broken_file_is_told_in_plain_words(self):
        corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
        head = (
            "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\n"
            "property float y\nproperty float z\nelement face {}\n"
            "property list uchar int vertex_indices\nend_header\n"
        )
        binary = head.format("binary_little_endian", 10**18, 10**18)
        binary += "\0" * 100
        cases = (
            ("a.obj", f"{corners}f 1 2 9223372036854775807\n", "not there"),
            ("a.obj", f"{corners}f 1 2 -99\n", "a face names a vertex"),
            ("a.obj", "v 1e308 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "at 1e+308"),
            ("a.ply", binary, "it is cut short"),
            ("a.ply", head.format("ascii", "x", "y"), "not of that form"),
            ("a.ply", "ply\nformat ascii 1.0\n" + "comment x\n" * 9, "early"),
        )
        for name, text, words in cases:
            with self.subTest(text=text[:40]):
                path = self.folder / name
                path.write_text(text)
                self.refused_file(path, words, "allowed: ")
                # No words of a library's own.
                with self.assertRaises(TorsoError) as caught:
                    LoadScan(path)
                for raw in ("out of bounds", "list index", "'int'", "literal"):
                    self.assertNotIn(raw, str(caught.exception))

    def test_an_origin_that_is_no_place(self):
        scan = self.folder / "scan.ply"
        for far in (float("nan"), float("inf"), 1e10):
            with self.assertRaisesRegex(
                TorsoError, "origin is .* allowed: num"
            ):
                LoadScan(scan, ScanFrame(origin=(far, 0.0, 0.0)))

    def test_measures_take_no_unit(self):
        self.refused_file(GIRL, "measures are in m", arguments=["--unit", "mm"])

    def test_a_scenario_without_a_torso(self):
        path = scenario_path("leg_bench.scenario.yaml")
        status, _, errors = run_command(
            "personalize", GIRL, "--out", self.out, "--scenario", path
        )
        self.assertEqual(status, 2)
        self.assertIn("has no torso", errors)


class TestCommand(unittest.TestCase):
    def test_a_scan_becomes_a_torso_with_pads_and_a_scenario(self):
        with tempfile.TemporaryDirectory() as name:
            out = Path(name) / "out"
            status, text, _ = run_command(
                *("personalize", SCAN, "--unit", "mm", "--axes=+y-x+z"),
                *("--origin", 0, 0, 1184, "--out", out),
            )
            self.assertEqual(status, 0)
            self.assertEqual([p.name for p in Path(name).iterdir()], ["out"])
            torso = LoadTorso(out)
            scenario = LoadScenario(out / "bench.scenario.yaml")
            brace = LoadScenario(out / "brace.scenario.yaml")
            surface = LoadSurface(out / "torso.obj")
            picture = (out / "torso.png").read_bytes()
        self.assertTrue(picture.startswith(b"\x89PNG"))
        self.assertEqual(len(torso.pads), 6)
        mass = calc_inertia(*surface).get_mass()
        self.assertAlmostEqual(scenario.torso.mass / mass, 1.0, delta=1e-3)
        np.testing.assert_allclose(
            scenario.torso.inertia,
            np.diag(central_inertia(torso)),
            rtol=2e-3,
        )
        girl = make_parametric_loft(LoadMeasures(GIRL))
        self.assertAlmostEqual(
            scenario.contact.ring2.pad_offset,
            np.mean(half_widths(girl, 0.0)),
            delta=0.004,
        )
        self.assertEqual(brace.torso.mass, scenario.torso.mass)
        for pads, contact in zip(
            np.reshape(torso.pads, (3, 2)), brace.contacts, strict=True
        ):
            widths = [abs(pad.place.p_TP[1]) for pad in pads]
            self.assertAlmostEqual(
                contact.pad_offset, np.mean(widths), places=6
            )
        self.assertIn("bend of the trunk's centre line 2", text)


if __name__ == "__main__":
    unittest.main()
