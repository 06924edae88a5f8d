"""The brace with 18 legs as bodies against the one without."""

import re
import tempfile
import unittest
from itertools import pairwise
from pathlib import Path

import numpy as np
from pydrake.geometry import Role
from pydrake.systems.framework import DiagramBuilder

from brace_drake.core.errors import ScenarioError
from brace_drake.core.resources import sdf_path
from brace_drake.kinematics import find_task_coordinates, leg_lengths
from brace_drake.model.articulated import (
    GetDrives,
    WriteBraceModels,
    calc_closure_error,
    make_models,
)
from brace_drake.model.articulated.links import make_bare_ring
from brace_drake.model.brace_plant import AddBracePlant, SetBracePose
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import geometry_of, pack_brace
from tests.brace_runs import brace, hold, replay, run, run_servo
from tests.brace_servo import BraceServo
from tests.test_kinematics import some_poses

NUMBER = re.compile(r"(?<![\w.])(-?\d+\.?\d*(?:e-?\d+)?)(?![\w.])")
MOTION = np.zeros(18)
MOTION[[1, 7, 9, 13, 14]] = -0.004, -0.008, 0.05, -0.006, 0.004


def make_plant(scenario):
    plant = AddBracePlant(DiagramBuilder(), scenario)
    return plant, plant.CreateDefaultContext()


class TestModels(unittest.TestCase):
    def check_same(self, first, second):
        """The same but for numbers' last digits, which processors differ in."""
        parts = NUMBER.split(first), NUMBER.split(second)
        self.assertEqual(parts[0][::2], parts[1][::2])
        numbers = [np.array(p[1::2], dtype=float) for p in parts]
        np.testing.assert_allclose(*numbers, rtol=1e-12, atol=1e-14)

    def test_the_files_are_those_of_the_numbers(self):
        for name, text in make_models(BraceScenario()).items():
            with self.subTest(file=name):
                self.check_same(sdf_path(name).read_text(), text)

    def test_the_tool_writes_the_files(self):
        with tempfile.TemporaryDirectory() as folder:
            for path in WriteBraceModels(BraceScenario(), Path(folder)):
                ours = sdf_path(path.name).read_text()
                self.check_same(path.read_text(), ours)

    def test_masses_are_those_of_the_task_space_brace(self):
        scenario = brace("articulated")
        plant, context = make_plant(scenario)
        legs = 18 * (scenario.leg.tube_mass + scenario.leg.rod_mass)
        # Half of the lowest legs hangs on the clamped ring, which is there too.
        total = 4 * scenario.ring.mass + legs / 6
        self.assertAlmostEqual(plant.CalcTotalMass(context), total, places=12)

    def test_a_bare_ring_and_halves_of_legs_make_the_ring(self):
        scenario = BraceScenario()
        numbers = pack_brace(scenario)
        geometry = geometry_of(numbers)
        half = 0.5 * (scenario.leg.tube_mass + scenario.leg.rod_mass)
        for i in range(3):
            ring = make_bare_ring(scenario, geometry, i)
            points = [*geometry.upper[i]]
            points += [*geometry.lower[i + 1]] if i < 2 else []
            moments = np.zeros(3)
            for x, y, z in points:
                squares = [y * y + z * z, x * x + z * z, x * x + y * y]
                moments += half * np.array(squares)
            self.assertAlmostEqual(
                ring.mass + half * len(points), scenario.ring.mass, places=12
            )
            np.testing.assert_allclose(
                np.diag(ring.I_LLcm) + moments, scenario.ring.inertia
            )

    def test_a_ring_lighter_than_its_legs_is_refused(self):
        scenario = brace("articulated")
        scenario.leg.tube_mass = 0.5
        with self.assertRaisesRegex(ScenarioError, "^ring.mass is 0.85"):
            MakeBraceStation(scenario)

    def test_rings_and_legs_are_drawn_where_there_is_a_scene_graph(self):
        drawn = []

        def count(plant, scene_graph, scenario):
            inspector = scene_graph.model_inspector()
            drawn.append(inspector.NumGeometriesWithRole(Role.kIllustration))

        AddBracePlant(DiagramBuilder(), brace("articulated"), count)
        self.assertEqual(drawn, [4 * 24 + 18 * 2])

    def test_legs_of_several_lengths_have_a_file_each(self):
        scenario = brace("articulated", stages=[1])
        scenario.joints.stage1.upper.angles_deg[0] += 3.0
        names = [n for n in make_models(scenario) if n.startswith("leg")]
        self.assertEqual(names, [f"leg1_{k}.sdf" for k in range(1, 7)])
        plant, context = make_plant(scenario)
        self.assertLess(calc_closure_error(plant, context, scenario), 1e-14)


class TestKinematics(unittest.TestCase):
    def test_drives_have_the_lengths_of_the_kinematics(self):
        scenario = brace("articulated")
        plant, context = make_plant(scenario)
        geometry = geometry_of(pack_brace(scenario))
        for X in some_poses(np.random.default_rng(1), 10):
            SetBracePose(plant, context, scenario, X)
            ways = [
                d.get_translation(context) for d in GetDrives(plant, scenario)
            ]
            np.testing.assert_allclose(
                geometry.rest_lengths + ways,
                leg_lengths(geometry, X),
                rtol=0,
                atol=1e-12,
            )
            error = calc_closure_error(plant, context, scenario)
            self.assertLess(error, 1e-12)

    def test_drives_keep_those_lengths_in_motion(self):
        scenario = brace("articulated", time_step=1e-3)
        station, simulator, _ = run_servo(scenario, MOTION, 0.2)
        plant = station.plant
        context = plant.GetMyContextFromRoot(simulator.get_context())
        ways = [d.get_translation(context) for d in GetDrives(plant, scenario)]
        self.assertLess(calc_closure_error(plant, context, scenario), 1e-6)
        read = station.diagram.GetOutputPort("leg_length")
        np.testing.assert_allclose(
            geometry_of(station.numbers).rest_lengths + ways,
            read.Eval(simulator.get_context()),
            rtol=0,
            atol=1e-6,
        )

    def test_statics_are_the_slope_of_the_height_of_all_masses(self):
        # Virtual work, legs with masses of their own: no Jacobian in it.
        scenario = brace("articulated", time_step=1e-3)
        X = 0.5 * some_poses(np.random.default_rng(2), 1)[0]
        for i, name in enumerate(scenario.rings):
            setattr(scenario.start, name, X[6 * i : 6 * i + 6])
        servo = BraceServo(pack_brace(scenario), kp=6400.0)
        station = MakeBraceStation(scenario, servo, hold(X))
        log = station.sink.FindLog(
            run(station.diagram, 1.2).get_context()
        ).data()
        held, lengths = log[0:18, -1], log[18:36, -1]
        plant, context = make_plant(scenario)
        geometry, step = geometry_of(pack_brace(scenario)), 1e-5
        expected = np.empty(18)
        for k, way in enumerate(step * np.eye(18)):
            energy = []
            for sign in (1.0, -1.0):
                at = find_task_coordinates(geometry, lengths + sign * way, X)
                SetBracePose(plant, context, scenario, at)
                energy.append(plant.CalcPotentialEnergy(context))
            expected[k] = (energy[0] - energy[1]) / (2 * step)
        self.assertGreater(np.abs(held).min(), 1.0)
        np.testing.assert_allclose(held, expected, rtol=1e-6)


class TestMotion(unittest.TestCase):
    def test_braces_move_alike_as_far_as_their_legs_are_light(self):
        scenario = brace(time_step=1e-4)
        scenario.sensors.log_period = 1e-3
        duration = 0.2
        _, _, expected = run_servo(scenario, MOTION, duration)
        differences = []
        for share in (1.0, 0.1, 0.01):
            other = brace("articulated", time_step=1e-4)
            other.sensors.log_period = 1e-3
            other.leg.tube_mass *= share
            other.leg.rod_mass *= share
            _, _, log = replay(other, expected[:, 0:18], duration)
            lengths = log[:, 18:36] - expected[:, 18:36]
            differences.append(np.abs(lengths).max())
        moved = np.abs(expected[:, 18:36] - expected[0, 18:36]).max()
        self.assertGreater(moved, 1e-3)
        self.assertLess(differences[2], 0.01 * moved)
        for heavy, light in pairwise(differences):
            self.assertAlmostEqual(heavy / light, 10.0, delta=1.0)

    def test_loops_stay_closed(self):
        scenario = brace("articulated", time_step=1e-3)
        worst = [0.0]

        def watch(station):
            plant = station.plant

            def look(context):
                if round(context.get_time() * 1000) % 50 == 0:
                    own = plant.GetMyContextFromRoot(context)
                    error = calc_closure_error(plant, own, scenario)
                    worst[0] = max(worst[0], error)

            return look

        run_servo(scenario, MOTION, 3.0, watch, back=True)
        self.assertLess(worst[0], 1e-6)
        self.assertGreater(worst[0], 0.0)

    def test_drives_stop_at_the_ends_of_their_strokes(self):
        scenario = brace("articulated", time_step=1e-3, stages=[1])
        station, simulator, _ = replay(scenario, [np.full(6, 20.0)], 0.5)
        plant = station.plant
        context = plant.GetMyContextFromRoot(simulator.get_context())
        ways = [d.get_translation(context) for d in GetDrives(plant, scenario)]
        np.testing.assert_allclose(ways, 0.025, atol=2e-4)


if __name__ == "__main__":
    unittest.main()
