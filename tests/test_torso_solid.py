"""Surfaces, solids, masses and pads of torsos against closed forms."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

from brace_drake.core.errors import TorsoError
from brace_drake.core.resources import scenario_path
from brace_drake.scenario.brace import BenchScenario
from brace_drake.torso.faces import make_pads
from brace_drake.torso.fitted import calc_inertia, fit_torso, loft_surface
from brace_drake.torso.grid import make_grid
from brace_drake.torso.loft import (
    Loft,
    half_widths,
    loft_points,
    loft_radius,
    measure_cobb,
    measure_trunk_bend,
    side_point,
)
from brace_drake.torso.measures import (
    Curve,
    LoadMeasures,
    TorsoMeasures,
    make_parametric_loft,
)
from brace_drake.torso.pads import place_pads
from brace_drake.torso.solid import (
    deepest,
    fill_outlines,
    signed_volumes,
    split_wedges,
    surface_volume,
)

RINGS = (-0.09, 0.0, 0.06)
SIZE = (0.06, 0.08)
SCOLIOTIC = Curve(
    cobb_deg=40.0, apex=-0.02, convex="right", axial_rotation_deg=-12.0
)


def cylinder(half_depth, half_breadth, low=-0.2, high=0.2, m=256, n=9):
    """A straight elliptic cylinder about z."""
    measures = TorsoMeasures(
        np.array([low, high]),
        np.full(2, 2.0 * half_breadth),
        np.full(2, 2.0 * half_depth),
        2.0,
    )
    return make_parametric_loft(measures, n, m)


def ellipsoid(a, b, c, n=401, m=256):
    """An ellipsoid whose poles are cut at 1e-4 of its height."""
    z = c * np.sin(np.linspace(-0.5, 0.5, n) * np.pi * 0.9999)
    shrink = np.sqrt(1.0 - (z / c) ** 2)[:, None]
    angles = np.arange(m) * 2 * np.pi / m
    radii = 1.0 / np.hypot(np.cos(angles) / a, np.sin(angles) / b)
    return Loft(z, np.zeros((n, 2)), angles, shrink * radii)


def edges_of(triangles):
    return np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])


class TestSurface(unittest.TestCase):
    def test_nominal_half_widths_are_the_pad_offset_of_the_bench(self):
        loft = make_parametric_loft(TorsoMeasures())
        for height in RINGS:
            for width in half_widths(loft, height):
                self.assertAlmostEqual(
                    width, BenchScenario().contact.ring2.pad_offset, delta=1e-5
                )

    def test_the_file_of_the_nominal_torso_holds_the_defaults(self):
        path = scenario_path("torso_nominal.measures.yaml")
        ours, theirs = TorsoMeasures(), LoadMeasures(path)
        for key in ("heights", "breadths", "depths", "exponent"):
            np.testing.assert_array_equal(
                getattr(ours, key), getattr(theirs, key)
            )
        self.assertEqual(ours.curve, theirs.curve)

    def test_the_curve_has_the_cobb_angle_that_was_asked_for(self):
        for asked in (0.0, 10.0, 25.0, 40.0, 60.0):
            for convex in ("left", "right"):
                curve = Curve(asked, 0.0, 0.06, convex)
                loft = make_parametric_loft(TorsoMeasures(curve=curve), 641)
                measured = measure_cobb(loft.heights, loft.centres[:, 1])
                self.assertAlmostEqual(measured, asked, delta=0.01)
                apex = loft.centres[np.argmax(np.abs(loft.centres[:, 1])), 1]
                self.assertEqual(apex > 0.0, convex == "left" and asked > 0)

    def test_the_bend_of_the_surface_is_that_of_the_curve(self):
        # The sections' centres of area carry the curve; smoothing takes some.
        loft = make_parametric_loft(TorsoMeasures(curve=SCOLIOTIC))
        self.assertAlmostEqual(measure_trunk_bend(loft), 40.0, delta=2.5)
        straight = make_parametric_loft(TorsoMeasures())
        self.assertAlmostEqual(measure_trunk_bend(straight), 0.0, places=6)

    def test_the_right_side_of_a_right_curve_is_turned_back(self):
        loft = make_parametric_loft(TorsoMeasures(curve=SCOLIOTIC))
        # Where the widest point of the right side has gone.
        turn = np.deg2rad(-12.0)
        angle = -0.5 * np.pi + turn
        radius = loft_radius(loft, angle, -0.02)
        self.assertAlmostEqual(float(radius), 0.15, delta=1e-4)
        self.assertLess(radius * np.cos(angle), -0.03)
        # Far from the apex nothing has turned.
        angle = -0.5 * np.pi
        straight = make_parametric_loft(TorsoMeasures())
        self.assertAlmostEqual(
            float(loft_radius(loft, angle, -0.37)),
            float(loft_radius(straight, angle, -0.37)),
            places=6,
        )

    def test_radii_between_knots_lie_on_the_chord(self):
        loft = cylinder(0.1, 0.1, m=8)
        angle = np.pi / 8
        self.assertAlmostEqual(
            float(loft_radius(loft, angle, 0.01)), 0.1 * np.cos(np.pi / 8)
        )

    def test_side_points_are_on_the_side(self):
        loft = cylinder(0.12, 0.15, m=2048)
        for side in (1, -1):
            for x in (-0.03, 0.0, 0.03):
                y = side * 0.15 * np.sqrt(1.0 - (x / 0.12) ** 2)
                np.testing.assert_allclose(
                    side_point(loft, 0.05, side, x), [x, y, 0.05], atol=1e-6
                )

    def test_the_surface_is_closed_and_faces_outward(self):
        loft = make_parametric_loft(TorsoMeasures(curve=SCOLIOTIC), 41, 48)
        vertices, triangles = loft_surface(loft)
        edges, counts = np.unique(
            edges_of(triangles), axis=0, return_counts=True
        )
        self.assertTrue(np.all(counts == 1))
        back = np.unique(edges[:, ::-1], axis=0)
        np.testing.assert_array_equal(edges, back)
        # Euler: a sphere.
        count = len(vertices) - len(edges) // 2 + len(triangles)
        self.assertEqual(count, 2)
        self.assertGreater(surface_volume(vertices, triangles), 0.02)


class TestMass(unittest.TestCase):
    def test_an_elliptic_cylinder(self):
        a, b, h = 0.12, 0.15, 0.4
        inertia = calc_inertia(*loft_surface(cylinder(a, b, -0.1, 0.3)))
        mass = 1000.0 * np.pi * a * b * h
        self.assertAlmostEqual(inertia.get_mass() / mass, 1.0, delta=2e-4)
        np.testing.assert_allclose(inertia.get_com(), [0, 0, 0.1], atol=1e-9)
        central = inertia.Shift(inertia.get_com()).CalcRotationalInertia()
        moments = mass * np.array(
            [b**2 / 4 + h**2 / 12, a**2 / 4 + h**2 / 12, (a**2 + b**2) / 4]
        )
        np.testing.assert_allclose(central.get_moments(), moments, rtol=5e-4)
        np.testing.assert_allclose(central.get_products(), 0.0, atol=1e-12)

    def test_an_ellipsoid(self):
        a, b, c = 0.1, 0.15, 0.25
        inertia = calc_inertia(*loft_surface(ellipsoid(a, b, c)))
        mass = 1000.0 * 4.0 / 3.0 * np.pi * a * b * c
        self.assertAlmostEqual(inertia.get_mass() / mass, 1.0, delta=2e-4)
        squares = np.array([a, b, c]) ** 2
        moments = mass / 5.0 * (squares.sum() - squares)
        found = inertia.CalcRotationalInertia().get_moments()
        np.testing.assert_allclose(found, moments, rtol=5e-4)

    def test_the_proxy_of_a_girl_weighs_what_her_trunk_does(self):
        # 45 % of 50.6 kg: Plagenhoef's share, the mean of the same women.
        path = scenario_path("torso_girl13.measures.yaml")
        surface = loft_surface(make_parametric_loft(LoadMeasures(path)))
        mass = calc_inertia(*surface).get_mass()
        self.assertLess(abs(mass / (0.45 * 50.6) - 1.0), 0.1)


class TestSolid(unittest.TestCase):
    def solid(self, curve, resolution=0.03):
        loft = make_parametric_loft(TorsoMeasures(curve=curve))
        places = place_pads(loft, RINGS, SIZE)
        solid = fill_outlines(*make_grid(loft, places, resolution))
        return solid, loft, places

    def test_tetrahedra_are_positive_and_fill_the_surface(self):
        for curve in (Curve(), SCOLIOTIC):
            for resolution in (0.03, 0.015):
                solid, _, _ = self.solid(curve, resolution)
                volumes = signed_volumes(solid.vertices, solid.tetrahedra)
                self.assertGreater(volumes.min(), 0.0)
                inside = surface_volume(solid.vertices, solid.triangles)
                self.assertAlmostEqual(volumes.sum() / inside, 1.0, places=12)
                edges = np.sort(edges_of(solid.triangles), axis=1)
                _, counts = np.unique(edges, axis=0, return_counts=True)
                self.assertTrue(np.all(counts == 2))

    def test_its_volume_converges_to_that_of_the_surface(self):
        errors = []
        for resolution in (0.04, 0.02, 0.01):
            solid, loft, _ = self.solid(SCOLIOTIC, resolution)
            volume = surface_volume(solid.vertices, solid.triangles)
            errors.append(1.0 - volume / surface_volume(*loft_surface(loft)))
        self.assertLess(errors[1], 0.5 * errors[0])
        self.assertLess(errors[2], 0.5 * errors[1])
        self.assertLess(errors[2], 0.003)

    def test_wedges_share_the_diagonals_of_their_faces(self):
        # All orders of six nodes: each face's cut must be at its smallest.
        random = np.random.default_rng(0)
        corners = np.array(
            [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]]
        )
        faces = [(0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
        for _ in range(200):
            names = random.permutation(6)
            cut = split_wedges(names[None])
            where = np.argsort(names)
            volumes = signed_volumes(corners[where].astype(float), cut)
            np.testing.assert_allclose(volumes, 1.0 / 6.0)
            pairs = {
                frozenset((int(a), int(b))) for t in cut for a in t for b in t
            }
            for face in faces:
                own = names[list(face)]
                k = int(np.argmin(own))
                cut_here = frozenset((int(own[k]), int(own[(k + 2) % 4])))
                other = frozenset(
                    (int(own[(k + 1) % 4]), int(own[(k + 3) % 4]))
                )
                self.assertIn(cut_here, pairs)
                self.assertNotIn(other, pairs)

    def test_the_deepest_node_of_a_cylinder_is_its_radius_deep(self):
        loft = cylinder(0.1, 0.1, -0.3, 0.3, m=64)
        solid = fill_outlines(loft.outlines, loft.axis)
        self.assertAlmostEqual(
            deepest(solid), 0.1 * np.cos(np.pi / 64), places=9
        )

    def test_sections_that_differ_too_much_are_refused(self):
        loft = cylinder(0.1, 0.1, m=16)
        outlines = loft.outlines.copy()
        # Half a turn of one section about the axis.
        outlines[4, :, :2] *= -1.0
        with self.assertRaisesRegex(TorsoError, "inside out.*allowed: 0"):
            fill_outlines(outlines, loft.axis)

    def test_a_grid_too_coarse_for_the_shape_is_refused(self):
        loft = make_parametric_loft(TorsoMeasures())
        with self.assertRaisesRegex(TorsoError, "finer resolution"):
            fit_torso(loft, RINGS, SIZE, 0.1)


class TestPads(unittest.TestCase):
    def pads(self, loft, resolution=0.01):
        places = place_pads(loft, RINGS, SIZE)
        solid = fill_outlines(*make_grid(loft, places, resolution))
        return make_pads(solid, places)

    def test_a_cylinders_pads_sit_and_press_as_the_closed_form_says(self):
        radius, half = 0.15, 0.5 * SIZE[0]
        for pad in self.pads(cylinder(radius, radius), 0.004):
            side = pad.place.side
            z = RINGS[pad.place.ring - 1]
            np.testing.assert_allclose(
                pad.place.p_TP, [0, side * radius, z], atol=2e-5
            )
            np.testing.assert_allclose(
                pad.place.normal, [0, side, 0], atol=1e-9
            )
            np.testing.assert_allclose(
                pad.surface_normal, [0, side, 0], atol=1e-6
            )
            # ∫ cos^2 over the arc: r (α + sin α cos α) times the height.
            angle = np.arcsin(half / radius)
            area = SIZE[1] * radius * (angle + np.sin(angle) * np.cos(angle))
            self.assertAlmostEqual(pad.effective_area / area, 1.0, delta=5e-4)

    def test_a_shifted_and_turned_torso_shifts_and_turns_its_pads(self):
        turn, shift = np.deg2rad(8.0), 0.02
        loft = cylinder(0.12, 0.15)
        angles = loft.angles + turn
        moved = Loft(
            loft.heights,
            loft.centres + np.array([0.0, shift]),
            angles,
            loft.radii,
        )
        into = np.array(
            [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
        )
        axes = np.array([0.12, 0.15])
        for pad in self.pads(moved):
            # The ellipse in its own axes, and its gradient there.
            own = into @ (pad.place.p_TP[:2] - [0.0, shift])
            self.assertAlmostEqual(pad.place.p_TP[0], 0.0, places=9)
            self.assertAlmostEqual(np.sum((own / axes) ** 2), 1.0, delta=1e-3)
            normal = into.T @ (own / axes**2)
            normal /= np.linalg.norm(normal)
            angle = np.arccos(pad.place.normal[:2] @ normal)
            # A chord's direction is not quite the tangent in its middle.
            self.assertLess(np.rad2deg(angle), 0.5)

    def test_left_and_right_mirror_each_other(self):
        pads = self.pads(make_parametric_loft(TorsoMeasures()))
        self.assertEqual(
            [p.place.name for p in pads],
            [f"ring{i}_{s}" for i in (1, 2, 3) for s in ("left", "right")],
        )
        for left, right in zip(pads[::2], pads[1::2], strict=True):
            np.testing.assert_allclose(
                left.place.p_TP * [1, -1, 1], right.place.p_TP, atol=1e-9
            )
            self.assertAlmostEqual(
                left.effective_area / right.effective_area, 1.0, places=6
            )

    def test_faces_lie_on_the_surface_and_face_the_torso(self):
        loft = make_parametric_loft(TorsoMeasures(curve=SCOLIOTIC))
        for pad in self.pads(loft, 0.005):
            self.assertTrue(np.all(pad.area_vectors @ pad.place.normal > 0))
            z = pad.vertices[:, 2]
            centres = np.column_stack(
                [np.interp(z, loft.heights, c) for c in loft.centres.T]
            )
            ray = pad.vertices[:, :2] - centres
            on = loft_points(loft, np.arctan2(ray[:, 1], ray[:, 0]), z)
            away = np.linalg.norm(pad.vertices - on, axis=1)
            self.assertLess(away.max(), 1e-4)

    def test_a_torso_that_ends_below_the_pads_is_refused(self):
        with self.assertRaisesRegex(TorsoError, r"ring 3 need 0\.020 to 0\.10"):
            place_pads(cylinder(0.1, 0.15, -0.2, 0.05), RINGS, SIZE)


class TestMeasures(unittest.TestCase):
    def refused(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "some.measures.yaml"
            path.write_text(text)
            with self.assertRaises(TorsoError) as caught:
                LoadMeasures(path)
        message = str(caught.exception)
        self.assertNotIn("\n", message)
        self.assertIn("some.measures.yaml", message)
        return message

    def test_bad_measures_are_told_in_one_line(self):
        cases = {
            "breadth: [1]": ("breadth", "breadths"),
            "breadths: [0.3, 0.3]": ("breadths", "8 numbers"),
            "breadths: [1, 1, 1, 1, 1, 1, 1, 346]": ("breadths", "0.05 to 0.6"),
            "depths: [0.2, x]": ("depths[1]", "a number"),
            "heights: [0.1, 0.0]": ("heights", "above the last"),
            "exponent: .nan": ("exponent", "1.5 to 5"),
            "curve: {cobb_deg: 120}": ("curve.cobb_deg", "0 to 100"),
            "curve: {convex: up}": ("curve.convex", "left or right"),
            "curve: 3": ("curve", "a map"),
            "a: [": ("not YAML",),
        }
        for text, words in cases.items():
            with self.subTest(text=text):
                message = self.refused(text)
                for word in words:
                    self.assertIn(word, message)


if __name__ == "__main__":
    unittest.main()
