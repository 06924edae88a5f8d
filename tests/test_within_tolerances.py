"""Tolerances as priors, and the criterion that counts with them."""

import math
import unittest
from dataclasses import replace

import numpy as np

from brace_drake.devices.bench.device import Bench
from brace_drake.devices.bench.drawn import draw_tolerances, uses_of_draws
from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import LeastSquaresSolution
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording import Campaign, LoadCampaign
from brace_drake.scenario.brace import BenchScenario
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import decide
from brace_drake.selection.tolerated import is_within
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


def fit_of(keys: str, misfit: float, predicted: float) -> CandidateFit:
    """A fit that leaves so much of a thousand values."""
    effects = tuple(find_effect(k) for k in keys.split("+") if k)
    number = 1 + sum(len(e.parameters) for e in effects)
    solution = LeastSquaresSolution(
        np.ones(number), np.zeros(1000), None, 0, True
    )
    return CandidateFit(
        effects,
        np.ones(1),
        tuple(e.starts()[0] for e in effects),
        solution,
        np.ones(number),
        1000.0 * misfit,
        None,
        2,
        refined=True,
        held_out=predicted,
    )


class TestCriterion(unittest.TestCase):
    def setUp(self):
        self.nominal = fit_of("", 10.0, 10.0)
        self.criterion = Criterion(self.nominal, 1000)

    def test_an_effect_pays_if_it_leaves_less_than_a_quarter(self):
        quarter = 0.25 * (10.0 + thresholds.LEVEL) - thresholds.LEVEL
        for factor, pays in ((0.95, True), (1.05, False)):
            left = factor * quarter
            fit = fit_of("relaxation", left, left)
            score = self.criterion.score(fit)
            self.assertEqual(score < self.criterion.score(self.nominal), pays)

    def test_what_imitates_a_gap_in_sample_alone_is_not_named(self):
        imitates = fit_of("force_scale", 1.0, 9.0)
        verdict = decide(self.criterion, [imitates])
        self.assertEqual(verdict.effects, ())
        self.assertTrue(verdict.outside_library)

    def test_less_than_the_level_says_nothing(self):
        one = fit_of("relaxation", 0.04, 0.04)
        two = fit_of("relaxation+force_bias", 0.0, 0.0)
        verdict = decide(self.criterion, [two, one])
        self.assertEqual(verdict.effects, ("relaxation",))
        self.assertFalse(verdict.outside_library)

    def test_a_certain_effect_is_named_beside_a_rest_that_is_unknown(self):
        large = Criterion(fit_of("", 1000.0, 1000.0), 1000)
        fits = [
            fit_of("coulomb_friction", 60.0, 65.0),
            fit_of("relaxation", 950.0, 950.0),
        ]
        verdict = decide(large, fits)
        self.assertEqual(verdict.effects, ("coulomb_friction",))
        self.assertTrue(verdict.outside_library)
        self.assertGreater(verdict.supported[0].probability, 0.9)
        self.assertGreater(verdict.unexplained, thresholds.MATERIAL)
        # An effect that takes next to nothing is not supported.
        self.assertEqual(decide(large, fits[1:]).effects, ())

    def test_a_tolerance_that_is_stretched_far_costs_more_than_an_effect(self):
        stretched = replace(fit_of("", 0.0, 0.0), stretch=8.0)
        effect = fit_of("ring_mass", 0.0, 0.0)
        criterion = Criterion(stretched, 1000)
        self.assertLess(criterion.score(effect), criterion.score(stretched))

    def test_an_effect_within_its_tolerance_is_no_finding(self):
        card = find_effect("ring_mass")
        use = ((card, np.array([0.015])),)
        nuisances = [Nuisance("ring_mass_kg", "kg", "mechanism", 0.015, use)]
        for mass, within in ((0.03, True), (-0.03, True), (0.15, False)):
            found = is_within((card, np.array([mass])), None, nuisances)
            self.assertEqual(found, within)
        other = find_effect("relaxation")
        use = (other, other.starts()[0])
        self.assertFalse(is_within(use, None, nuisances))

    def test_probabilities_of_all_explanations_are_one(self):
        verdict = decide(self.criterion, [fit_of("relaxation", 0.05, 0.05)])
        self.assertTrue(0.5 < verdict.probability <= 1.0)
        self.assertTrue(math.isfinite(verdict.probability))


if __name__ == "__main__":
    unittest.main()
