"""The Drake diagram of the bench against the compiled rollout."""

import unittest

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.devices.bench.rollout import Motion, simulate_bench
from brace_drake.devices.motions.reference import reference_at_ticks
from brace_drake.effects.registry import find_effect
from brace_drake.effects.stack import modify_numbers, stack_effects
from brace_drake.laws.control import brace_control
from brace_drake.model.brace_station import (
    MakeBraceStation,
    MakeControlledBrace,
)
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from brace_drake.scenario.brace_numbers import pack_bench, pack_rings
from tests.brace_runs import along_y, bench_log

RATE, PIC = 1000.0, "controller"


def smooth_push(duration: float = 1.5, depth: float = -0.01):
    """Times and y, y', y'' of a quintic push that ends at rest."""
    time = np.linspace(0.0, duration, round(duration * 200) + 1)
    s = time / duration
    y = depth * s**3 * (10 - 15 * s + 6 * s**2)
    dy = depth * 30 * s**2 * (1 - s) ** 2 / duration
    ddy = depth * 60 * s * (1 - s) * (1 - 2 * s) / duration**2
    return time, np.column_stack([y, dy, ddy])


def held_at_ticks(draws):
    """Draws at ticks, each held from half a period before its tick."""
    edges = (np.arange(len(draws)) - 0.5) / RATE
    return PiecewisePolynomial.ZeroOrderHold(edges, draws.T)


def run_both(scenario, noise=None, uses=()):
    """Logs of the diagram and of the rollout for the same push."""
    time, samples = smooth_push()
    numbers = modify_numbers(pack_bench(scenario), uses)
    plug_ins = stack_effects(uses, numbers)
    station = MakeControlledBrace(
        scenario,
        along_y(time, samples),
        uses=uses,
        noise=None if noise is None else held_at_ticks(noise),
    )
    desired = reference_at_ticks(time, samples, RATE)
    scaled = None if noise is None else noise * numbers.noise_sigma
    rollout = simulate_bench(
        numbers,
        Motion(desired, scenario.torso.present),
        scenario.time_step,
        plug_ins,
        scaled,
    )
    return bench_log(station, time[-1]), rollout


def bench(time_step=5e-4, with_torso=True) -> BenchScenario:
    scenario = BenchScenario(time_step=time_step)
    scenario.torso.present = with_torso
    return scenario


def ports_of(diagram):
    """Names and sizes of a diagram's inputs and outputs."""
    inputs = map(diagram.get_input_port, range(diagram.num_input_ports()))
    outputs = map(diagram.get_output_port, range(diagram.num_output_ports()))
    return tuple(
        {(p.get_name(), p.size()) for p in s} for s in (inputs, outputs)
    )


class TestDiagramEqualsRollout(unittest.TestCase):
    # Drake solves for accelerations in another order: rounding, times the
    # stiffness of the loop, makes a few nN.
    TOLERANCE = 1e-8

    def test_push_agrees_in_every_column(self):
        for time_step in (5e-4, 2e-4):
            with self.subTest(time_step=time_step):
                log, rollout = run_both(bench(time_step))
                self.assertEqual(log.shape, rollout.shape)
                np.testing.assert_allclose(
                    log, rollout, rtol=0, atol=self.TOLERANCE
                )
                self.assertGreater(np.abs(log[:, 13]).max(), 5.0)

    def test_free_motion_agrees_in_every_column(self):
        log, rollout = run_both(bench(with_torso=False))
        np.testing.assert_allclose(log, rollout, rtol=0, atol=self.TOLERANCE)

    def test_effects_agree_without_a_torso(self):
        friction = find_effect("coulomb_friction")
        values = np.array([p.starts[0] for p in friction.parameters])
        scenario = bench(with_torso=False)
        log, rollout = run_both(scenario, uses=[(friction, values)])
        np.testing.assert_allclose(log, rollout, rtol=0, atol=1e-6)

    def test_the_same_noise_gives_the_same_run(self):
        generator = np.random.default_rng(3)
        noise = generator.standard_normal((1501, 12))
        log, rollout = run_both(bench(), noise)
        # A reading next to a rounding edge may fall either way, and the run
        # then differs by less than the noise does.
        same = np.isclose(log, rollout, rtol=0, atol=1e-7).all(axis=1)
        self.assertGreater(same.mean(), 0.99)
        quiet, _ = run_both(bench())
        spread = (log - quiet)[:, 6:12].std()
        self.assertGreater(spread, 3e-6)

    def test_effects_agree(self):
        names = ("coulomb_friction", "relaxation", "force_scale", "hardening")
        for name in names:
            effect = find_effect(name)
            values = np.array([p.starts[0] for p in effect.parameters])
            with self.subTest(effect=name):
                log, rollout = run_both(bench(), uses=[(effect, values)])
                np.testing.assert_allclose(log, rollout, rtol=0, atol=1e-6)


class TestStation(unittest.TestCase):
    def setUp(self):
        time, samples = smooth_push(0.3)
        self.reference = along_y(time, samples)

    def run_with(self, station, change=lambda context: None):
        simulator = Simulator(station.diagram)
        change(simulator.get_mutable_context())
        simulator.AdvanceTo(0.3)
        context = simulator.get_context()
        return station.sink.FindLog(context).data()[7].copy()

    def test_ports_are_those_of_the_brace(self):
        brace = BraceScenario(stages=[2])
        controller = MakeController(brace.control, pack_rings(brace))
        expected = ports_of(MakeBraceStation(brace, controller).diagram)
        station = MakeControlledBrace(bench(), self.reference)
        inputs, outputs = ports_of(station.diagram)
        # The reference takes the place of `desired`.
        self.assertEqual(inputs, expected[0] - {("desired", 18)})
        self.assertEqual(outputs, expected[1])

    def test_a_stiffness_changed_in_the_context_changes_the_run(self):
        station = MakeControlledBrace(bench(), self.reference)
        law = station.diagram.GetSubsystemByName("force_law")

        def soften(context):
            own = law.GetMyMutableContextFromRoot(context)
            # Of the pads: after rest, viscous and the anchors.
            own.get_mutable_numeric_parameter(0).SetAtIndex(45, 3200.0)

        scenario = bench()
        scenario.contact.ring2.stiffness = 3200.0
        rebuilt = MakeControlledBrace(scenario, self.reference)
        softened = self.run_with(station, soften)
        np.testing.assert_array_equal(softened, self.run_with(rebuilt))
        changed = np.abs(softened - self.run_with(station)).max()
        self.assertGreater(changed, 1e-4)

    def test_doubled_gain_in_the_context_equals_a_rebuilt_station(self):
        station = MakeControlledBrace(bench(), self.reference)
        system = station.diagram.GetSubsystemByName(PIC)

        def double(context):
            own = system.GetMyMutableContextFromRoot(context)
            law = own.get_mutable_numeric_parameter(0)
            for i in range(6):
                law.SetAtIndex(brace_control.K_P * 6 + i, 3200.0)

        scenario = bench()
        scenario.control.inner.kp[:] = 3200.0
        rebuilt = MakeControlledBrace(scenario, self.reference)
        np.testing.assert_array_equal(
            self.run_with(station, double), self.run_with(rebuilt)
        )

    def test_a_rest_reference_leaves_the_bench_at_rest(self):
        still = PiecewisePolynomial(np.zeros((18, 1)))
        station = MakeControlledBrace(bench(), still)
        log = bench_log(station, 0.2)
        # Preloaded pads press equally from both sides.
        np.testing.assert_allclose(log[:, 12:18], 0.0, atol=1e-9)
        weight = 0.85 * 9.81
        self.assertAlmostEqual(log[-1, 0:6].sum() / weight, 1.6, delta=0.8)


if __name__ == "__main__":
    unittest.main()
