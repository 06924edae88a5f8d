"""The pad bench's Drake diagram agrees with its compiled rollout."""

import unittest

import numpy as np

from brace_drake.core.resources import scenario_path
from brace_drake.devices.pad_bench.motion import MakePadMotion
from brace_drake.devices.pad_bench.twin import simulate_pad
from brace_drake.effects.registry import find_effect
from brace_drake.effects.stack import stack_effects
from brace_drake.model.pad_station import MakePadBenchStation, SimulatePadBench
from brace_drake.scenario.load import LoadScenario
from brace_drake.scenario.pad_bench import PadBenchScenario, pack_pad_bench

RATE = 100.0


def use(name: str, **values: float):
    effect = find_effect(name)
    return effect, effect.vector(values)


class TestAgreement(unittest.TestCase):
    def check(self, uses):
        """Readings along presses that leave the tissue and come back."""
        scenario = PadBenchScenario(contact_offset=0.002)
        numbers, time = pack_pad_bench(scenario), np.arange(200) / RATE
        displacement = 0.008 * np.sin(5.0 * time) + 0.001 * np.sin(31.0 * time)
        path = MakePadMotion(time, displacement, 0.0).path()
        plug_ins = stack_effects(uses)
        compiled = simulate_pad(numbers, time, path, 0.002, plug_ins)
        station = MakePadBenchStation(numbers, time, path, 0.002, plug_ins)
        diagram = SimulatePadBench(station)
        # Ticks come 1e-10 s early; 1 m/s^2 times that on 150 N s/m.
        np.testing.assert_allclose(diagram, compiled, rtol=0.0, atol=1e-7)
        return compiled

    def test_nominal(self):
        force = self.check([])
        self.assertGreater(force.max(), 30.0)
        self.assertEqual(force.min(), 0.0)

    def test_with_relaxation_and_hardening(self):
        uses = [
            use("relaxation", arm_stiffness_N_m=2000.0, relaxation_time_s=0.3),
            use("hardening", cubic_stiffness_N_m3=5e7),
        ]
        change = np.abs(self.check(uses) - self.check([])).max()
        self.assertGreater(change, 5.0)

    def test_with_an_effect_in_the_sensor(self):
        biased = self.check([use("force_bias", force_bias_N=0.7)])
        np.testing.assert_allclose(biased, self.check([]) + 0.7, atol=1e-12)

    def test_the_scenario_file_is_the_default(self):
        scenario = LoadScenario(scenario_path("pad_bench.scenario.yaml"))
        self.assertEqual(repr(scenario), repr(PadBenchScenario()))


if __name__ == "__main__":
    unittest.main()
