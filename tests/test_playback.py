"""3D playbacks: complete in themselves, and where kinematics says."""

import re
import tempfile
import unittest
from pathlib import Path

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from brace_drake.core.errors import BraceError, ScenarioError
from brace_drake.core.resources import scenario_path
from brace_drake.kinematics import leg_lengths
from brace_drake.laws import stages
from brace_drake.playback import (
    WritePlayback,
    place_on_pads,
    states_of_readings,
    states_of_run,
)
from brace_drake.playback.look import make_look
from brace_drake.playback.meshes import make_ring_mesh, make_torso_mesh
from brace_drake.playback.scales import (
    calc_pressures,
    colour_of,
    newtons_per_metre,
)
from brace_drake.playback.scene import leg_anchors
from brace_drake.playback.write import StartLocalMeshcat
from brace_drake.recording import LoadCampaign
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from brace_drake.scenario.leg_bench import LegBenchScenario
from brace_drake.torso.meshes import obj_text
from tests.brace_runs import brace, run_servo
from tests.commands import run_command
from tests.meshcat_page import read_commands, read_tracks
from tests.test_simulate_command import write_reference


def motion(scenario, duration=2.0):
    """States of a made up motion, and its task coordinates."""
    geometry = make_look(scenario).geometry
    n, t = geometry.num_stages, np.arange(0.0, duration + 1e-9, 0.01)
    rates = 1.0 + 0.3 * np.arange(6 * n)
    X = 0.01 * np.sin(t[:, None] * rates)
    X[:, 1] -= 0.02
    lengths = np.array([leg_lengths(geometry, x) for x in X])
    force = 4.0 * np.cos(np.outer(t, 1.0 + np.arange(3 * n)))
    torso = np.array([0.0, 0.0, 0.235]) + 0.003 * np.sin(t)[:, None]
    return states_of_readings(geometry, t, lengths, force, torso), X, force


class TestPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scenario = BraceScenario()
        cls.look = make_look(cls.scenario)
        cls.states, cls.X, cls.force = motion(cls.scenario)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "run.html"
            WritePlayback(cls.scenario, cls.states, path, "a <run>")
            cls.page = path.read_text()
        force = cls.force.reshape(-1, 3)
        cls.largest = np.linalg.norm(force, axis=1).max()
        cls.rate, cls.tracks = read_tracks(cls.page)

    def pose(self, path, frame):
        p = np.array(self.tracks[path, ".position"][frame])
        x, y, z, w = self.tracks[path, ".quaternion"][frame]
        return p, RotationMatrix(Quaternion(w, x, y, z))

    def test_the_page_loads_nothing_from_outside(self):
        loads = r"""src\s*=\s*["']?(?:https?:)?//|@import|<link"""
        self.assertEqual(re.findall(loads, self.page), [])
        # The viewer's button for headsets is a plain link.
        links = re.findall(r'href\s*=\s*"(https?:[^"]+)', self.page)
        self.assertLessEqual(set(links), {"https://immersiveweb.dev/"})
        self.assertNotIn("cdn.", self.page)
        fetched = re.findall(r'fetch\("(\w+):', self.page)
        self.assertEqual(set(fetched), {"data"})
        self.assertIn("a &lt;run&gt;", self.page)
        self.assertIn(f"largest {self.largest:.1f} N", self.page)
        self.assertLess(len(self.page), 12e6)

    def test_the_animation_has_25_frames_a_second(self):
        self.assertEqual(self.rate, 25.0)
        for keys in self.tracks.values():
            # 2 s at 25 frames a second, both ends.
            self.assertEqual(sorted(keys), list(range(51)))

    def test_legs_stand_between_the_anchors_of_the_kinematics(self):
        for frame in (0, 13, 40):
            sample = 4 * frame
            poses = np.empty((3, 7))
            stages.place_rings(self.X[sample], self.look.geometry.rest, poses)
            lengths, J, _ = self.look.geometry.at(self.X[sample])
            for k in range(18):
                a, R = self.pose(f"/brace/leg{k + 1}/tube", frame)
                b, _ = self.pose(f"/brace/leg{k + 1}/rod", frame)
                self.assertAlmostEqual(
                    np.linalg.norm(b - a), lengths[k], delta=1e-9
                )
                # Row k of J begins with the leg's direction.
                direction = J[k // 6][k % 6, 0:3]
                np.testing.assert_allclose(
                    (b - a) / lengths[k], direction, atol=1e-8
                )
                np.testing.assert_allclose(R.col(2), direction, atol=1e-8)
                if k < 6:
                    lower = self.look.geometry.lower[0, k]
                    np.testing.assert_allclose(a, lower, atol=1e-9)

    def test_rings_are_where_the_readings_say(self):
        for i, ring in enumerate(("ring1", "ring2", "ring3")):
            p, R = self.pose(f"/brace/{ring}", 17)
            x = self.X[68, 6 * i : 6 * i + 6]
            rest = self.look.geometry.rest[i]
            np.testing.assert_allclose(p, rest + x[:3], atol=1e-8)
            turn = R.ToAngleAxis()
            np.testing.assert_allclose(
                turn.angle() * turn.axis(), x[3:], atol=1e-7
            )

    def test_arrows_lie_along_the_force_and_are_as_long(self):
        scale = newtons_per_metre(self.states.pad_force)
        for frame in range(51):
            force = self.force[4 * frame, 3:6]
            side, other = ("left", "right")[:: -1 if force[1] > 0 else 1]
            path = f"/forces/ring2_{side}"
            tip, R = self.pose(f"{path}/head", frame)
            neck, _ = self.pose(f"{path}/shaft", frame)
            shaft = self.tracks[f"{path}/shaft", ".scale"][frame][2]
            vector = (tip - (neck - shaft * R.col(2))) * scale
            np.testing.assert_allclose(vector, force, atol=1e-6)
            # Pads press inwards: the arrow comes from outside its pad.
            pad = self.states.rings[4 * frame, 1, 4:7]
            self.assertGreater((tip[1] - pad[1]) * (side == "left" or -1), 0.1)
            gone = self.tracks[f"/forces/ring2_{other}/head", ".scale"]
            self.assertLess(max(gone[frame]), 0.01)

    def test_pads_are_the_darker_the_more_they_press(self):
        pressures = calc_pressures(
            self.states.rings, self.states.pad_force, self.look.contacts
        )[::4]
        self.assertGreater(pressures.max(), 300.0)
        for i in range(3):
            for side, word in enumerate(("left", "right")):
                path = f"/brace/ring{i + 1}/{word}_pad/body/<object>"
                keys = self.tracks[path, ".material.color"]
                own = pressures[:, i, side]
                # 4 N and more on 48 cm^2: the scale ends at 1 kPa.
                for frame in range(51):
                    np.testing.assert_allclose(
                        keys[frame], colour_of(own[frame] / 1000.0)
                    )
                green = [keys[k][1] for k in np.argsort(own, kind="stable")]
                self.assertTrue((np.diff(green) <= 0.0).all())
        self.assertIn("0 to 1\n    kPa", self.page)

    def test_all_shapes_of_the_brace_are_there(self):
        paths = {
            c["path"]
            for c in read_commands(self.page)
            if c["type"] == "set_object"
        }
        for part in ("leg18/rod", "ring3/left_pad", "clamped", "ring1"):
            self.assertIn(f"/brace/{part}/body", paths)
        self.assertIn("/torso/body", paths)
        self.assertIn("/axes/z", paths)
        self.assertEqual(sum("/ball" in p for p in paths), 36)


class TestStates(unittest.TestCase):
    def test_pressure_is_the_force_into_the_torso_over_the_face(self):
        turned = np.cos(np.pi / 4), 0.0, 0.0, np.sin(np.pi / 4)
        rings = np.zeros((2, 1, 7))
        rings[:, 0, 0:4] = (1.0, 0.0, 0.0, 0.0), turned
        # 4.8 N on 60 x 80 mm are 1 kPa; a quarter turn takes y to -x.
        force = np.zeros((2, 1, 2, 3))
        force[0, 0] = [3.0, -4.8, 1.0], [0.0, 2.4, 0.0]
        force[1, 0] = [4.8, -2.0, 0.0], [4.8, 0.0, 0.0]
        contact = BraceScenario().contact.ring1
        found = calc_pressures(rings, force, [contact])
        expected = [[[1000.0, 500.0]], [[1000.0, 0.0]]]
        np.testing.assert_allclose(found, expected, atol=1e-9)
        free = calc_pressures(rings, force, [None])
        np.testing.assert_array_equal(free, 0.0)

    def test_anchors_at_rest_are_those_of_the_joint_circles(self):
        look = make_look(BenchScenario())
        rest = np.array([[1.0, 0, 0, 0, 0, 0, 0.235]])
        lower, upper = leg_anchors(look, rest)
        np.testing.assert_allclose(np.hypot(*lower[:, :2].T), 0.19)
        np.testing.assert_allclose(np.hypot(*upper[:, :2].T), 0.18)
        np.testing.assert_allclose(lower[:, 2], 0.145)
        np.testing.assert_allclose(upper[:, 2], 0.235)

    def test_a_push_along_minus_y_is_shown_at_the_left_pad(self):
        placed = place_on_pads(np.array([[1.0, -4.0, 0.5], [0, 3.0, 0]]))
        np.testing.assert_array_equal(placed[0, 0, 0], [1.0, -4.0, 0.5])
        np.testing.assert_array_equal(placed[0, 0, 1], 0.0)
        np.testing.assert_array_equal(placed[1, 0, 1], [0.0, 3.0, 0.0])
        np.testing.assert_array_equal(placed.sum(axis=2)[:, 0, 1], [-4, 3])

    def test_a_run_of_either_mechanism_ends_where_its_plant_does(self):
        for mechanism in ("task_space", "articulated"):
            with self.subTest(mechanism=mechanism):
                scenario = brace(mechanism, "linear", stages=[2])
                X = np.array([0.0, -0.004, 0.002, 0.0, 0.02, 0.0])
                station, simulator, log = run_servo(scenario, X, 0.1)
                context = simulator.get_context()
                states = states_of_run(
                    station, context, scenario.rings, log[:, 12:15]
                )
                own = station.plant.GetMyContextFromRoot(context)
                for name, pose in (
                    ("ring2", states.rings[-1, 0]),
                    ("torso", states.torso[-1]),
                ):
                    body = station.plant.GetBodyByName(name)
                    X_WB = station.plant.EvalBodyPoseInWorld(own, body)
                    # The plant has made its step at the last sample.
                    V = station.plant.EvalBodySpatialVelocityInWorld(own, body)
                    step = V.translational() * scenario.time_step
                    np.testing.assert_allclose(
                        pose[4:7] + step, X_WB.translation(), atol=1e-9
                    )
                self.assertGreater(
                    np.abs(np.diff(states.rings[:, 0, 5])).max(), 1e-5
                )
                # The same rings by forward kinematics from the readings.
                by_reading = states_of_readings(
                    make_look(scenario).geometry,
                    states.times,
                    log[:, 6:12],
                    log[:, 12:15],
                    None,
                )
                tolerance = 1e-5 if mechanism == "task_space" else 1e-4
                np.testing.assert_allclose(
                    by_reading.rings, states.rings, atol=tolerance
                )

    def test_a_device_without_rings_is_refused(self):
        with self.assertRaisesRegex(ScenarioError, "leg bench"):
            make_look(LegBenchScenario())

    def test_frames_are_the_nearest_samples(self):
        states, _, _ = motion(BenchScenario(), 0.5)
        np.testing.assert_array_equal(
            states.frames(30.0), np.round(np.arange(16) / 0.3).astype(int)
        )

    def test_the_scale_is_round_and_keeps_arrows_in_view(self):
        for largest in (0.03, 0.9, 4.0, 37.0, 119.0):
            force = np.zeros((2, 1, 2, 3))
            force[1, 0, 0, 1] = -largest
            scale = newtons_per_metre(force)
            self.assertTrue(0.04 < largest / scale <= 0.12 + 1e-12)
            self.assertIn(f"{scale:e}"[0], "125")


class TestShapes(unittest.TestCase):
    def volume(self, vertices, faces):
        a, b, c = (vertices[:, k] for k in faces)
        return np.einsum("ij,ij", a, np.cross(b, c, axis=0)) / 6.0

    def edges(self, faces):
        return [
            (int(a), int(b))
            for t in faces.T
            for a, b in zip(t, np.roll(t, -1), strict=True)
        ]

    def test_surfaces_are_closed_and_face_outwards(self):
        for mesh in (
            make_ring_mesh(np.array([0.205, 0.205]), 0.011, 0.006),
            make_torso_mesh(0.15, 0.11, -0.3, 0.2),
        ):
            edges = self.edges(mesh[1])
            self.assertEqual(len(edges), len(set(edges)))
            self.assertEqual({e[::-1] for e in edges}, set(edges))
            self.assertGreater(self.volume(*mesh), 0.0)

    def test_the_ring_is_a_torus_with_the_outer_edge_asked_for(self):
        vertices, faces = make_ring_mesh(np.array([0.2, 0.2]), 0.01, 0.006)
        self.assertAlmostEqual(np.hypot(*vertices[:2]).max(), 0.2)
        # Pappus: section times the way of its centre.
        expected = np.pi * 0.01 * 0.006 * 2.0 * np.pi * 0.19
        found = self.volume(vertices, faces)
        self.assertAlmostEqual(found / expected, 1.0, delta=0.06)

    def test_the_torso_touches_the_pads(self):
        vertices, _ = make_torso_mesh(0.15, 0.11, -0.3, 0.2)
        y, z = vertices[1:3]
        self.assertAlmostEqual(y.max(), 0.15)
        self.assertAlmostEqual(y.min(), -0.15)
        # As wide as that but for its ends.
        widest = z[y > 0.15 - 1e-9]
        self.assertLess(widest.min(), -0.25)
        self.assertGreater(widest.max(), 0.15)
        self.assertAlmostEqual(vertices[2].min(), -0.3)


class TestCommand(unittest.TestCase):
    def test_simulate_writes_a_playback_of_the_bench_beside_its_campaign(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            reference = write_reference(folder / "push.csv")
            page, scenario = folder / "push.html", "bench.scenario.yaml"
            code, said, _ = run_command(
                *("simulate", scenario_path(scenario), "--motion", reference),
                *("--out", folder / "campaign", "--html", page),
            )
            self.assertEqual(code, 0)
            self.assertIn(str(page), said)
            rate, tracks = read_tracks(page.read_text())
            (run,) = LoadCampaign(folder / "campaign").runs
            ring = tracks["/brace/ring2", ".position"]
            self.assertEqual(len(ring), int(run.time_s[-1] * rate) + 1)
            torso = tracks["/torso", ".position"]
            marker = run.channels["torso_y_m"]
            for frame, p in torso.items():
                sample = round(frame / rate * 200.0)
                self.assertAlmostEqual(p[1], marker[sample], delta=1e-5)
            self.assertGreater(np.ptp([p[1] for p in ring.values()]), 1e-3)

    def test_only_this_machine_reaches_the_live_view(self):
        self.assertTrue(
            StartLocalMeshcat().web_url().startswith("http://localhost:")
        )

    def test_a_torso_from_a_file_is_held_in_the_page(self):
        states, _, _ = motion(BenchScenario(), 0.05)
        vertices, faces = make_torso_mesh(0.14, 0.1, -0.2, 0.2)
        with tempfile.TemporaryDirectory() as folder:
            mesh, page = Path(folder) / "torso.obj", Path(folder) / "run.html"
            mesh.write_text(obj_text(vertices.T, faces.T))
            WritePlayback(BenchScenario(), states, page, torso_mesh=mesh)
            commands = read_commands(page.read_text())
        (torso,) = (
            c["object"]
            for c in commands
            if c["type"] == "set_object" and c["path"] == "/torso/body"
        )
        text = torso["geometries"][0]["data"]
        self.assertEqual(
            text.count("\nv ") + text.startswith("v "), len(vertices.T)
        )

    def test_a_page_that_cannot_be_written_is_told(self):
        states, _, _ = motion(BenchScenario(), 0.05)
        with self.assertRaisesRegex(BraceError, "nowhere"):
            WritePlayback(BenchScenario(), states, "/nowhere/at/all.html")


if __name__ == "__main__":
    unittest.main()
