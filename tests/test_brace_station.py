"""The diagram of the brace: its case of one stage, and its statics."""

import unittest

import numpy as np
from pydrake.systems.framework import LeafSystem

from brace_drake.core.errors import ScenarioError
from brace_drake.kinematics import find_task_coordinates, static_leg_forces
from brace_drake.model.brace_plant import SetBracePose
from brace_drake.model.brace_station import (
    MakeBraceStation,
    MakeControlledBrace,
)
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import geometry_of, pack_brace
from tests.brace_runs import (
    along_y,
    bench_log,
    brace,
    hold,
    replay,
    run,
    run_servo,
)
from tests.brace_servo import BraceServo
from tests.test_station import smooth_push


class TestBench(unittest.TestCase):
    def test_stage_2_alone_is_the_bench(self):
        bench = BenchScenario(time_step=5e-4)
        bench.sensors.log_period = 0.001
        duration = 0.3
        station = MakeControlledBrace(bench, along_y(*smooth_push(duration)))
        expected = bench_log(station, duration)
        scenario = brace(contact="linear", stages=[2], time_step=5e-4)
        scenario.sensors.log_period = 0.001
        _, _, log = replay(scenario, expected[:, 0:6], duration)
        np.testing.assert_allclose(log, expected[:, 0:18], rtol=0, atol=1e-12)
        self.assertGreater(np.abs(expected[:, 13]).max(), 2.0)


class TestStatics(unittest.TestCase):
    X = np.concatenate(
        [
            [1e-3, -4e-3, 2e-3, 0.02, -0.01, 0.03],
            [2e-3, -8e-3, 4e-3, -0.02, 0.03, 0.01],
            [-2e-3, -5e-3, 5e-3, 0.01, 0.04, -0.03],
        ]
    )

    def test_leg_forces_hold_any_load_in_the_plant(self):
        scenario = brace(time_step=1e-3)
        station = MakeBraceStation(scenario)
        diagram, plant = station.diagram, station.plant
        load = np.random.default_rng(5).uniform(-3, 3, (3, 6))
        weight = np.zeros((3, 6))
        weight[:, 2] = 0.85 * 9.81
        context = diagram.CreateDefaultContext()
        own = plant.GetMyMutableContextFromRoot(context)
        SetBracePose(plant, own, scenario, self.X)
        f = static_leg_forces(
            geometry_of(station.numbers), self.X, (weight - load).ravel()
        )
        self.assertLess(np.abs(f).max(), 120.0)
        diagram.GetInputPort("leg_command").FixValue(context, f)
        forces = diagram.GetSubsystemByName("forces")
        generalized = forces.GetOutputPort("generalized_force").Eval(
            forces.GetMyContextFromRoot(context)
        )
        expected = np.roll(weight - load, 3, axis=1)
        np.testing.assert_allclose(
            generalized.reshape(3, 6), expected, rtol=0, atol=1e-6 * 8.3
        )

    def test_the_weight_alone_stays_where_it_is_held(self):
        scenario = brace(time_step=1e-3)
        for i, name in enumerate(scenario.rings):
            own = self.X[6 * i : 6 * i + 6]
            setattr(scenario.start, name, own)
        numbers = pack_brace(scenario)
        weight = np.zeros((3, 6))
        weight[:, 2] = 0.85 * 9.81
        f = static_leg_forces(geometry_of(numbers), self.X, weight.ravel())
        station, simulator, log = replay(scenario, [f], 0.01)
        plant, context = station.plant, simulator.get_context()
        v = plant.GetVelocities(plant.GetMyContextFromRoot(context))
        # Free fall would have brought 0.1 m/s.
        self.assertLess(np.abs(v).max(), 1e-7)
        np.testing.assert_allclose(log[0, 18:36], log[-1, 18:36], atol=1e-9)

    def test_a_command_beyond_the_limit_is_cut(self):
        scenario = brace(stages=[1])
        _, _, log = replay(scenario, [[500.0, -500, 1, 1, 1, 1]], 1e-3)
        np.testing.assert_array_equal(log[0, 0:6], [120, -120, 1, 1, 1, 1])


class TestStages(unittest.TestCase):
    def test_any_neighbouring_stages_stand_alone(self):
        for stages in ([1], [3], [1, 2], [2, 3]):
            for mechanism in ("task_space", "articulated"):
                scenario = brace(
                    mechanism, "linear", stages=stages, time_step=5e-4
                )
                X = np.zeros(6 * len(stages))
                X[1::6] = -5e-4
                for name in scenario.rings:
                    setattr(scenario.start, name, X[0:6])
                with self.subTest(stages=stages, mechanism=mechanism):
                    servo = BraceServo(pack_brace(scenario))
                    station = MakeBraceStation(scenario, servo, hold(X))
                    context = run(station.diagram, 0.02).get_context()
                    log = station.sink.FindLog(context).data().T
                    n = len(stages)
                    self.assertEqual(log.shape[1], 33 * n + 3)
                    found = find_task_coordinates(
                        geometry_of(station.numbers), log[-1, 6 * n : 12 * n]
                    )
                    np.testing.assert_allclose(found, X, atol=3e-4)
                    pushes = log[-1, 12 * n + 1 : 15 * n : 3]
                    self.assertTrue((pushes < 0).all())


class TestPorts(unittest.TestCase):
    def test_controllers_of_another_size_are_refused(self):
        one = BraceServo(pack_brace(brace(stages=[2])))
        with self.assertRaisesRegex(
            ScenarioError, "leg_length has size 6; allowed: 18"
        ):
            MakeBraceStation(brace(), one)

    def test_controllers_without_a_port_are_refused(self):
        with self.assertRaisesRegex(ScenarioError, "controller: .*leg_length"):
            MakeBraceStation(brace(), LeafSystem())

    def test_what_nothing_feeds_is_a_port_of_the_diagram(self):
        scenario = brace(contact="linear")
        servo = BraceServo(pack_brace(scenario))
        diagram = MakeBraceStation(scenario, servo).diagram
        self.assertEqual(diagram.GetInputPort("desired").size(), 54)
        self.assertEqual(diagram.GetInputPort("noise").size(), 30)
        open_loop = MakeBraceStation(scenario).diagram
        self.assertEqual(open_loop.GetInputPort("leg_command").size(), 18)
        for name, size in (("leg_length", 18), ("force", 9), ("marker", 3)):
            self.assertEqual(diagram.GetOutputPort(name).size(), size)

    def test_noise_is_that_of_the_instruments(self):
        scenario = brace(contact="linear")
        station = MakeBraceStation(scenario)
        context = station.diagram.CreateDefaultContext()
        station.diagram.GetInputPort("leg_command").FixValue(
            context, np.zeros(18)
        )
        noise = station.diagram.GetInputPort("noise")
        read = station.diagram.GetOutputPort("leg_length")
        exact = read.Eval(context)
        noise.FixValue(context, np.full(30, 3.0))
        # 15 um, on a grid of 10 um.
        change = read.Eval(context) - exact
        self.assertTrue((np.abs(change - 15e-6) < 5.001e-6).all())

    def test_the_same_run_twice_is_the_same(self):
        scenario = brace(contact="linear", time_step=1e-3)
        X = np.zeros(18)
        X[7] = -0.004
        logs = [run_servo(scenario, X, 0.05)[2] for _ in range(2)]
        np.testing.assert_array_equal(*logs)


class TestGeometryHook(unittest.TestCase):
    def test_the_hook_sees_the_bodies_before_the_plant_is_final(self):
        seen = []

        def add(plant, scene_graph, scenario):
            self.assertFalse(plant.is_finalized())
            self.assertTrue(plant.geometry_source_is_registered())
            seen.extend(plant.HasBodyNamed(n) for n in scenario.rings)
            seen.append(plant.HasBodyNamed("torso"))

        MakeBraceStation(brace(contact="linear"), add_geometry=add)
        self.assertEqual(seen, [True] * 4)

    def test_hydroelastic_pads_press_as_the_linear_ones(self):
        X, forces = np.zeros(18), []
        X[[7, 13]] = -4e-4, -8e-4
        for model in ("linear", "hydroelastic"):
            scenario = brace(contact=model, time_step=1e-3)
            log = run_servo(scenario, X, 0.2)[2]
            forces.append(log[-1, 36:45].reshape(3, 3)[:, 1])
        linear, hydroelastic = forces
        self.assertLess(linear[2], -0.5)
        # Their friction sticks where the linear law creeps.
        np.testing.assert_allclose(hydroelastic, linear, rtol=0.2)


if __name__ == "__main__":
    unittest.main()
