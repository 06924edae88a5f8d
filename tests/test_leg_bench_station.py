"""The leg bench's Drake diagram agrees with its compiled rollout."""

import unittest

import numpy as np

from brace_drake.devices.leg_bench.twin import LegMotion, simulate_leg
from brace_drake.effects.stack import stack_effects
from brace_drake.model.leg_station import MakeLegBenchStation, SimulateLegBench
from brace_drake.scenario.leg_bench import LegBenchScenario, pack_leg_bench
from tests.test_leg_bench import RATE, starts_of


def make_motion(closed: bool = True) -> LegMotion:
    """A moving start, reversals, a pulse in the command and a load."""
    time = np.arange(400) / RATE
    asked = np.zeros((len(time), 3))
    asked[:, 0] = 0.01 * np.sin(20.0 * time) + 0.001 * np.sin(90.0 * time)
    asked[150:200, 1] = 40.0
    asked[250:, 2] = -15.0
    if not closed:
        asked[:, 1] = 60.0 * np.sin(15.0 * time)
    state = np.array([0.0002, 0.25])
    return LegMotion(asked, state, np.array([-5e-5, -3e-4]), closed)


class TestAgreement(unittest.TestCase):
    def check(self, motion, uses):
        scenario = LegBenchScenario(offset=-3.0)
        numbers, step = pack_leg_bench(scenario), scenario.time_step
        plug_ins = stack_effects(uses)
        station = MakeLegBenchStation(numbers, motion, step, plug_ins["drive"])
        diagram = SimulateLegBench(station)
        compiled = simulate_leg(numbers, motion, step, plug_ins)
        self.assertEqual(diagram.shape, compiled.shape)
        # Same laws, same order: rounding alone, through a stiff loop.
        np.testing.assert_allclose(diagram, compiled, rtol=0.0, atol=1e-8)
        return compiled

    def test_nominal(self):
        log = self.check(make_motion(), [])
        # The run does exercise the drive.
        self.assertGreater(np.ptp(log[:, 0]), 100.0)

    def test_open_loop(self):
        self.check(make_motion(closed=False), [])

    def test_with_coulomb_friction(self):
        use = starts_of("coulomb_friction", coulomb_N=20.0)
        log = self.check(make_motion(), [use])
        self.assertGreater(np.abs(log - self.check(make_motion(), [])).max(), 9)

    def test_with_two_effects(self):
        uses = [
            starts_of("coulomb_friction", coulomb_N=20.0),
            starts_of("command_delay", delay_s=0.0023),
        ]
        self.check(make_motion(), uses)


if __name__ == "__main__":
    unittest.main()
