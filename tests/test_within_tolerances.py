"""Tolerances as priors: what is within them is no gap."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.devices.bench.device import Bench
from brace_drake.devices.bench.drawn import draw_tolerances, uses_of_draws
from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording import Campaign, LoadCampaign
from brace_drake.scenario.brace import BenchScenario
from tests.shared_data import EXAMPLE


def known_tolerances(columns: np.ndarray) -> LinearTolerances:
    """Those whose change of the residual are given columns (rows, k)."""
    basis, coefficients = np.linalg.qr(columns)
    card = find_effect("force_bias")
    one = Nuisance("x", "N", "sensing", 1.0, ((card, np.ones(1)),))
    return LinearTolerances((one,) * columns.shape[1], basis, coefficients)


class TestTolerances(unittest.TestCase):
    def setUp(self):
        self.rng = np.random.default_rng(3)
        self.columns = self.rng.normal(size=(60, 4)) * [0.1, 1.0, 5.0, 40.0]
        self.known = known_tolerances(self.columns)

    def test_whitening_makes_pure_noise_of_what_tolerances_add(self):
        covariance = np.eye(60) + self.columns @ self.columns.T
        half = self.known.whiten(covariance)
        np.testing.assert_allclose(
            self.known.whiten(half.T), np.eye(60), atol=1e-9
        )

    def test_colouring_takes_whitening_back(self):
        residual = self.rng.normal(size=(60, 3))
        back = self.known.colour(self.known.whiten(residual))
        np.testing.assert_allclose(back, residual, atol=1e-10)

    def test_estimates_are_the_posterior_of_the_linear_gaussian_model(self):
        residual, noise = self.rng.normal(size=60), 2.5
        precision = self.columns.T @ self.columns / noise + np.eye(4)
        # r + J t is noise: t is the posterior mean under a unit normal prior.
        mean = -np.linalg.solve(precision, self.columns.T @ residual / noise)
        found = self.known.estimate(self.known.whiten(residual), noise)
        np.testing.assert_allclose(found, mean, atol=1e-9)
        deviation = np.sqrt(np.diag(np.linalg.inv(precision)))
        np.testing.assert_allclose(self.known.errors(noise), deviation)


class TestBenchWithinTolerances(unittest.TestCase):
    def test_a_machine_within_its_tolerances_has_no_gap_and_is_estimated(self):
        campaign = LoadCampaign(EXAMPLE)
        scenario = BenchScenario()
        # Friction sticks by chance, which no expectation tells.
        scenario.tolerances.leg_dry_friction = 0.0
        device = Bench(campaign, scenario)
        twin, rate = device.twin, campaign.rate_hz
        usual = np.array([p.nominal for p in twin.subject])
        drawn = draw_tolerances(scenario, 5)
        uses = uses_of_draws(scenario, drawn)
        runs = campaign.split("fit")[:3]
        short = Campaign(
            campaign.path, campaign.device, rate, "drawn", tuple(runs)
        )
        floors, _ = estimate_floors(twin, short, usual, 0)
        prepared = [
            replace(
                p,
                measured=twin.simulate(
                    p.motion, usual, uses, np.random.default_rng(p.seed)
                ),
            )
            for p in prepare_runs(twin, runs, floors, rate, 0)
        ]
        evaluator = Evaluator(twin, prepared, 2)
        exact = fit_nominal(evaluator)
        self.assertGreater(exact.excess / evaluator.count, 1.0)
        within = fit_nominal(evaluator, device.tolerances())
        self.assertLess(within.excess / evaluator.count, 0.1)
        self.assertLess(within.stretch, 5.0)
        residual = within.solution.residual[: evaluator.ends[-1]]
        off = evaluator.tolerances.estimate(residual)
        errors = evaluator.tolerances.errors()
        names = [n.name for n in evaluator.tolerances.nuisances]
        for name in ("ring_mass_kg", "leg_viscous_N_s_m", "force_bias_N"):
            place = names.index(name)
            size = evaluator.tolerances.nuisances[place].deviation
            true = drawn[name] / size
            with self.subTest(name):
                self.assertLess(errors[place], 1.0)
                distance = abs(off[place] - true)
                self.assertLess(distance, 4.0 * errors[place] + 0.1)


if __name__ == "__main__":
    unittest.main()
