"""A real ball-screw drive (EMPS) against its published model.

Published (Janot, Gautier, Brunot, 2019): 95.11 kg, 203.5 N s/m, Coulomb
20.39 N, offset -3.16 N; relative error 4.08 % in fit, 5.98 % on the run with
force pulses.
"""

import unittest
from pathlib import Path

import numpy as np
from scipy.special import chdtri

from brace_drake.core.cosine_transform import frequencies_of, to_frequency
from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording import LoadCampaign
from brace_drake.scenario.leg_bench import MakeLegBenchScenario

_ROOT = Path(__file__).resolve().parent.parent
_EMPS = _ROOT.parent / "shared" / "real" / "emps"


@unittest.skipUnless(_EMPS.is_dir(), f"no recordings of EMPS in {_EMPS}")
class TestEmps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.campaign = campaign = LoadCampaign(_EMPS)
        cls.twin = twin = LegBenchTwin(MakeLegBenchScenario(campaign))
        nominal = np.array([p.nominal for p in twin.subject])
        floors, _ = estimate_floors(twin, campaign, nominal, seed=0)
        rate = campaign.rate_hz
        fit_runs = campaign.split("fit")
        prepared = prepare_runs(twin, fit_runs, floors, rate, seed=0)
        evaluator = Evaluator(twin, prepared, jobs=2)
        cls.floor = floors[False]
        cls.nominal = fit_nominal(evaluator)
        coulomb = find_effect("coulomb_friction")
        cls.coulomb = fit_effects(evaluator, [coulomb], coulomb.starts())

    def residual(self, fit, split: str) -> np.ndarray:
        """Recorded minus replayed commands of the split's run, N."""
        (run,) = self.campaign.split(split)
        motion = self.twin.motion(run)
        replay = self.twin.simulate(motion, fit.subject, fit.uses)
        return (self.twin.measured(run) - replay)[:, 0]

    def relative_error(self, fit, split: str) -> float:
        """||F - F_sim|| / ||F|| of the commands in closed loop."""
        (run,) = self.campaign.split(split)
        force = np.linalg.norm(run.channels["force_command_N"])
        return float(np.linalg.norm(self.residual(fit, split)) / force)

    def test_with_coulomb_friction_the_published_model_comes_out(self):
        mass, viscous, offset = self.coulomb.subject
        self.assertAlmostEqual(mass / 95.11, 1.0, delta=0.03)
        self.assertAlmostEqual(viscous / 203.5, 1.0, delta=0.03)
        self.assertAlmostEqual(offset, -3.16, delta=0.1)
        friction = self.coulomb.values[0][0]
        self.assertAlmostEqual(friction / 20.39, 1.0, delta=0.03)

    def test_without_it_the_viscous_coefficient_takes_its_place(self):
        self.assertAlmostEqual(self.nominal.subject[1], 411.0, delta=8.0)

    def test_the_gap_on_the_run_with_pulses_closes(self):
        before = self.relative_error(self.nominal, "validation")
        after = self.relative_error(self.coulomb, "validation")
        self.assertGreater(before, 0.15)
        self.assertLess(after, 0.065)

    def test_the_external_force_is_part_of_the_command(self):
        (run,) = self.campaign.split("validation")
        self.assertTrue(self.twin.command_holds_external(run))
        rest = run.channels["force_command_N"] - self.twin.control_law(run)
        self.assertLess(np.nanstd(rest - run.channels["external_force_N"]), 0.2)

    def test_above_150_hz_the_residual_is_reading_noise(self):
        rest = self.residual(self.coulomb, "fit")
        rate = self.campaign.rate_hz
        weights = self.floor.weights(len(rest), rate)[:, 0]
        frequency = frequencies_of(len(rest), rate)
        inside = (frequency > 150.0) & (frequency < 490.0)
        power = (to_frequency(rest) * weights)[inside] ** 2
        # The median of a normal number's square.
        ratio = np.median(power) / chdtri(1, 0.5)
        self.assertAlmostEqual(np.sqrt(ratio), 1.0, delta=0.3)


if __name__ == "__main__":
    unittest.main()
