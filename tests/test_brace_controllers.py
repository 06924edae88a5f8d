"""The controllers as systems: ports and ticks."""

import unittest

import numpy as np
from pydrake.systems.analysis import Simulator

from brace_drake.core.errors import BraceError, ScenarioError
from brace_drake.kinematics import leg_jacobian, leg_lengths, make_geometry
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import pack_bench
from brace_drake.scenario.control_numbers import BraceRings
from brace_drake.scenario.controllers import TAGS, BraceControl
from tests.brace_loop import PERIOD, bench_rings

PAIRS = {13: [-13, 13, 107, 133, 227, 253], 47: [-47, 47, 73, 167, 193, 287]}


def three_rings():
    """The whole brace of the data sheet."""
    lower = [(r, PAIRS[13]) for r in (0.200, 0.190)]
    lower.append((0.180, [-10, 10, 110, 130, 230, 250]))
    upper = [(r, PAIRS[47]) for r in (0.190, 0.180)]
    upper.append((0.170, [-50, 50, 70, 170, 190, 290]))
    geometry = make_geometry(lower, upper, [0.0, 0.145, 0.235, 0.295])
    mass = np.array([[0.85, 0.0105, 0.0105, 0.0205]] * 3)
    mass[:, 0] += [0.0, 0.1, 0.2]
    return BraceRings(geometry, mass, np.full(18, 120.0))


class Ticks:
    """A controller alone, given what it reads tick by tick."""

    def __init__(self, dut, **inputs):
        self.dut, self.simulator = dut, Simulator(dut)
        self.context = self.simulator.get_mutable_context()
        self.fix(**inputs)
        self.ticks = 0

    def fix(self, **inputs):
        for name, values in inputs.items():
            self.dut.GetInputPort(name).FixValue(self.context, values)

    def tick(self, **inputs):
        self.fix(**inputs)
        if self.ticks == 0:
            self.simulator.Initialize()
        else:
            self.simulator.AdvanceTo(self.ticks * PERIOD)
        self.ticks += 1
        return self

    def output(self, name):
        return self.dut.GetOutputPort(name).Eval(self.context)


class TestSystems(unittest.TestCase):
    def test_all_have_the_same_ports(self):
        inputs = {"leg_length": 6, "force": 3, "desired": 18}
        outputs = {"leg_command": 6, "virtual": 18, "impedance": 18}
        one = bench_rings(pack_bench(BenchScenario()))
        for tag in TAGS:
            for n, rings in ((1, one), (3, three_rings())):
                dut = MakeController(BraceControl(tag=tag), rings)
                wanted = dict(inputs)
                if tag == "vpic":
                    wanted["stiffness"] = 6
                ports = {
                    dut.get_input_port(i).get_name(): i
                    for i in range(dut.num_input_ports())
                }
                with self.subTest(tag=tag, n=n):
                    self.assertEqual(set(ports), set(wanted))
                    for name, size in wanted.items():
                        port = dut.GetInputPort(name)
                        self.assertEqual(port.size(), n * size)
                    for name, size in outputs.items():
                        port = dut.GetOutputPort(name)
                        self.assertEqual(port.size(), n * size)

    def test_with_three_rings_commands_put_equation_six_on_the_rings(self):
        rings = three_rings()
        generator = np.random.default_rng(8)
        X = 1e-3 * generator.normal(size=18)
        X[3:6] *= 3.0
        desired = np.zeros((3, 18))
        desired[0] = 1e-3 * generator.normal(size=18)
        desired[2] = 0.1 * generator.normal(size=18)
        force = generator.normal(size=9)
        control = BraceControl(tag="idc")
        control.inner.kp = 900.0 + 10.0 * np.arange(18)
        control.inner.force_feedforward = ["x2", "y", "z"]
        dut = Ticks(MakeController(control, rings))
        dut.tick(
            leg_length=leg_lengths(rings.geometry, X),
            force=force,
            desired=desired.ravel(),
        )
        # In the first tick there is no velocity yet; the force is filtered.
        F = desired[2] + control.inner.kp * (desired[0] - X)
        F *= rings.task_mass
        F[2::6] += rings.mass[:, 0] * 9.81
        fed = force * (1.0 - np.exp(-PERIOD / 0.02))
        fed[[0, 6]] = 0.0
        F.reshape((3, 6))[:, :3] += fed.reshape((3, 3))
        J = leg_jacobian(rings.geometry, X)
        f = dut.output("leg_command")
        np.testing.assert_allclose(J.T @ f, F, atol=1e-9)

    def test_three_rings_have_impedances_of_their_own(self):
        control, rings = BraceControl(), three_rings()
        control.impedance.coordinates = ["y2", "x3"]
        control.impedance.stiffness = 1000.0 * np.arange(1.0, 10.0)
        dut = Ticks(
            MakeController(control, rings),
            leg_length=rings.geometry.rest_lengths,
            force=np.arange(9.0),
            desired=np.zeros(54),
        )
        for _ in range(600):
            dut.tick()
        expected, K = np.zeros(18), np.zeros(18)
        K[7], K[12] = 5000.0, 7000.0
        expected[7], expected[12] = -4.0 / K[7], -6.0 / K[12]
        virtual = dut.output("virtual")[:18]
        np.testing.assert_allclose(virtual, expected, atol=1e-9)
        np.testing.assert_array_equal(dut.output("impedance")[36:], K)

    def test_legs_out_of_reach_are_told(self):
        rings = three_rings()
        lengths = rings.geometry.rest_lengths.copy()
        lengths[7] += 0.5
        dut = Ticks(MakeController(BraceControl(), rings))
        with self.assertRaisesRegex(BraceError, "BracePic: no ring pose"):
            dut.tick(
                leg_length=lengths, force=np.zeros(9), desired=np.zeros(54)
            )


class TestStiffnessPort(unittest.TestCase):
    def setUp(self):
        self.rings = bench_rings(pack_bench(BenchScenario()))
        self.dut = Ticks(
            MakeController(BraceControl(tag="vpic"), self.rings),
            leg_length=self.rings.geometry.rest_lengths,
            force=np.zeros(3),
            desired=np.zeros(18),
        )

    def stiffness(self, asked, ticks=1):
        for _ in range(ticks):
            self.dut.tick(stiffness=np.full(6, asked))
        return self.dut.output("impedance")[13]

    def test_a_policy_sets_the_stiffness_within_limits_and_rate(self):
        first = self.stiffness(49990.0)
        self.assertTrue(6000.0 < first < 7000.0)
        self.assertEqual(self.stiffness(49990.0, 300), 49990.0)
        self.assertEqual(self.stiffness(1e6, 300), 50000.0)
        self.assertEqual(self.stiffness(-3.0), 500.0)
        M, C, K = self.dut.output("impedance").reshape((3, 6))[:, 1]
        self.assertAlmostEqual(C, 2.0 * np.sqrt(M * K))

    def test_unconnected_it_follows_the_rule_from_the_target(self):
        self.dut.tick()
        self.assertEqual(self.dut.output("impedance")[13], 6000.0)

    def test_a_policy_that_fails_is_told(self):
        self.dut.tick()
        with self.assertRaisesRegex(BraceError, "BraceVpic.*not a number"):
            self.stiffness(np.nan)


class TestMakeController(unittest.TestCase):
    def test_bad_numbers_are_refused_with_their_source(self):
        control = BraceControl(tag="npic")
        control.npic.kappa = 1.5
        with self.assertRaisesRegex(
            ScenarioError, r"here: npic\.kappa is 1\.5"
        ):
            MakeController(control, three_rings(), source="here")


if __name__ == "__main__":
    unittest.main()
