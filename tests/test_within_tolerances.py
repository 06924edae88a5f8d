"""Tolerances as priors: what is within them is no gap."""

import unittest
from dataclasses import replace
from unittest import mock

import numpy as np

from brace_drake.devices.bench.device import Bench
from brace_drake.devices.bench.drawn import draw_tolerances, uses_of_draws
from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.discrepancy import LawSearch
from brace_drake.effects.registry import effects_for, find_effect
from brace_drake.effects.stack import Use
from brace_drake.effects.unknown import terms_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.held_out import estimate_off
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities
from brace_drake.recording import Campaign, LoadCampaign
from brace_drake.scenario.brace import BenchScenario
from brace_drake.selection import thresholds
from brace_drake.selection.level import make_criterion
from brace_drake.selection.search.beyond import fit_beyond
from brace_drake.selection.search.candidate import with_one_more
from brace_drake.selection.search.exchange import exchanged
from brace_drake.selection.search.friction import (
    fit_behind_joints,
    fit_friction,
)
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.within import (
    refit_alone,
    refit_within,
    search_beside,
)
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

    def test_what_some_have_whitened_others_whiten_without_undoing_it(self):
        fewer = LinearTolerances(
            self.known.nuisances[:2],
            self.known.basis,
            self.known.columns[:, [0, 3]],
        )
        rows = self.known.whiten(self.rng.normal(size=(60, 3)))
        change = fewer.from_whitened(self.known)
        found = rows + fewer.basis @ (change @ (fewer.basis.T @ rows))
        np.testing.assert_allclose(
            found, fewer.whiten(self.known.colour(rows)), atol=1e-12
        )

    def test_whitening_makes_pure_noise_of_what_tolerances_add(self):
        covariance = np.eye(60) + self.columns @ self.columns.T
        half = self.known.whiten(covariance)
        np.testing.assert_allclose(
            self.known.whiten(half.T), np.eye(60), atol=1e-9
        )

    def test_beside_other_noise_numbers_weigh_as_their_prior_does_there(self):
        # Squares of the whitened residual times the noise are those of the
        # joint problem |r + J t|^2 / v + |t|^2, at its best t.
        noise, residual = 7.0, self.rng.normal(size=60)
        known = self.known.beside_noise(noise)
        whitened = known.whiten(residual)
        off = known.estimate(known.along(whitened), noise)
        rest = residual + self.columns @ off
        joint = rest @ rest / noise + off @ off
        self.assertAlmostEqual(whitened @ whitened / noise, joint, places=9)
        again = known.beside_noise(1.0)
        np.testing.assert_allclose(again.root, self.known.root, atol=1e-12)

    def test_weighed_beside_what_is_left_a_number_does_not_trade_an_effect(
        self,
    ):
        # A number acts nearly as an effect does, and what another effect
        # leaves lies along the difference.
        rows = np.eye(4)
        column = 10.0 * rows[0] + rows[1]
        size, other = 100.0, 30.0
        residual = size * rows[0] + other * rows[1]
        known = known_tolerances(column[:, None])
        estimates = []
        for noise in (1.0, other**2):
            weighed = known.beside_noise(noise)
            way = weighed.whiten(rows[0])
            left = weighed.whiten(residual)
            estimates.append(way @ left / (way @ way))
        # Of (x, t) that make (size - x - 10 t)^2 + (other - t)^2 + v t^2 least
        # t is other / (1 + v) and x is size - 10 t.
        expected = [size - 10.0 * other / (1.0 + v) for v in (1.0, other**2)]
        np.testing.assert_allclose(estimates, expected)
        self.assertLess(expected[0], 0.0)
        self.assertAlmostEqual(expected[1] / size, 1.0, delta=0.01)

    def test_colouring_takes_whitening_back(self):
        residual = self.rng.normal(size=(60, 3))
        back = self.known.colour(self.known.whiten(residual))
        np.testing.assert_allclose(back, residual, atol=1e-10)

    def test_estimates_are_the_posterior_of_the_linear_gaussian_model(self):
        residual, noise = self.rng.normal(size=60), 2.5
        precision = self.columns.T @ self.columns / noise + np.eye(4)
        # r + J t is noise: t is the posterior mean under a unit normal prior.
        mean = -np.linalg.solve(precision, self.columns.T @ residual / noise)
        found = self.known.estimate(
            self.known.along(self.known.whiten(residual)), noise
        )
        np.testing.assert_allclose(found, mean, atol=1e-9)
        deviation = np.sqrt(np.diag(np.linalg.inv(precision)))
        np.testing.assert_allclose(self.known.errors(noise), deviation)

    def test_numbers_that_are_off_in_the_replay_are_taken_back_to_zero(self):
        at_zero, off = self.rng.normal(size=60), self.rng.normal(size=4)
        there = replace(self.known, off=off)
        replayed = at_zero + self.columns @ off
        np.testing.assert_allclose(there.around_zero(replayed), at_zero)
        kept = there.beside([find_effect("reflex")])
        np.testing.assert_allclose(kept.off, off)
        self.assertIs(there.at_zero.around_zero(replayed), replayed)

    def test_numbers_moved_in_the_replay_keep_columns_and_their_limits(self):
        at_zero, off = self.rng.normal(size=60), self.rng.normal(size=4)
        friction = find_effect("coulomb_friction")
        rough = Nuisance("f", "N", "x", 0.1, ((friction, np.ones(1)),))
        one = self.known.nuisances[0]
        adds = replace(one, name="y", lower=0.0)
        all_four = (rough, adds, one, replace(one, name="z"))
        known = replace(self.known, nuisances=all_four)
        moved = known.at(off)
        # Friction is an effect where it bends, and what only adds only adds.
        np.testing.assert_allclose(moved.off, [0.0, max(off[1], 0.0), *off[2:]])
        replayed = at_zero + self.columns @ moved.off
        np.testing.assert_allclose(moved.around_zero(replayed), at_zero)
        part = moved.beside([friction]).at([1.0, 2.0, 3.0])
        np.testing.assert_allclose(part.off, [1.0, 2.0, 3.0])
        np.testing.assert_allclose(part.whole.off[1:], [1.0, 2.0, 3.0])


def drawn_bench(dry_friction: float, *effects: Use):
    """A bench that is drawn within its tolerances, and its recordings.

    Args:
        dry_friction: Its tolerance, N.
        effects: That it has beside.

    Returns:
        The device, what was drawn, and an evaluator over three runs.
    """
    campaign = LoadCampaign(EXAMPLE)
    scenario = BenchScenario()
    scenario.tolerances.leg_dry_friction = dry_friction
    device = Bench(campaign, scenario)
    twin, rate = device.twin, campaign.rate_hz
    usual = np.array([p.nominal for p in twin.subject])
    drawn = draw_tolerances(scenario, 5)
    uses = (*uses_of_draws(scenario, drawn), *effects)
    runs = campaign.split("fit")[:3]
    short = Campaign(campaign.path, campaign.device, rate, "drawn", tuple(runs))
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
    return device, drawn, Evaluator(twin, prepared, 2)


def criterion_of(device, evaluator):
    """A criterion with the nominal fit beside tolerances."""
    nuisances = device.tolerances()
    nominal = fit_nominal(evaluator, nuisances, device.uses_off)
    return make_criterion(evaluator, nominal, nuisances)


def with_friction(device, evaluator):
    """A criterion, and the fit with the friction that a tolerance allows."""
    criterion = criterion_of(device, evaluator)
    friction = list(effects_for(evaluator.twin.device).values())
    lines = Linearisation(evaluator, criterion.nominal)
    (fit,) = fit_friction(lines, criterion, friction)
    return criterion, fit


class TestBenchWithinTolerances(unittest.TestCase):
    def test_a_machine_within_its_tolerances_has_no_gap_and_is_estimated(self):
        # Without friction, which bends what the others do.
        device, drawn, evaluator = drawn_bench(dry_friction=0.0)
        exact = fit_nominal(evaluator)
        self.assertGreater(exact.excess / evaluator.count, 1.0)
        within = fit_nominal(evaluator, device.tolerances())
        self.assertLess(within.excess / evaluator.count, 0.1)
        self.assertLess(within.stretch, 5.0)
        residual = within.solution.residual[: evaluator.ends[-1]]
        off = evaluator.tolerances.estimate(
            evaluator.tolerances.along(residual)
        )
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

    def test_sensitivities_beside_little_friction_are_those_without(self):
        device, _, evaluator = drawn_bench(dry_friction=0.03)
        nominal = fit_nominal(evaluator, device.tolerances(), device.uses_off)
        card = find_effect("coulomb_friction (without creep)")
        n = len(nominal.subject)
        columns = {}
        for name, effects, values in (
            ("smooth", [], []),
            ("little", [card], [np.array([0.04])]),
            ("much", [card], [np.array([2.0])]),
        ):
            problem = CandidateProblem(evaluator, effects, values)
            z = problem.join(nominal.subject, values)
            found = calc_sensitivities(problem, z)[: evaluator.ends[-1], :n]
            # Each is whitened of the numbers that it does not stand for.
            columns[name] = problem.coloured(found)
            self.assertEqual(problem.sticks_little, name == "little")
        size = np.linalg.norm(columns["smooth"])
        little, much = (
            np.linalg.norm(columns[name] - columns["smooth"]) / size
            for name in ("little", "much")
        )
        self.assertLess(little, 0.03)
        self.assertGreater(much, 0.2)

    def test_numbers_of_a_machine_that_sticks_are_found_where_they_are(self):
        device, drawn, evaluator = drawn_bench(dry_friction=0.06)
        criterion, fit = with_friction(device, evaluator)
        nominal, nuisances = criterion.nominal, criterion.nuisances
        self.assertGreater(nominal.excess / evaluator.count, 0.5)
        self.assertLess(fit.excess, 0.1 * nominal.excess)
        self.assertLess(fit.stretch, thresholds.WITHIN)
        self.assertEqual(criterion.findings(fit), [])
        true = drawn["leg_dry_friction_N"]
        self.assertAlmostEqual(fit.values[0][0] / true, 1.0, delta=0.1)
        # They are replayed as they are, not on a straight line from zero.
        known = fit.tolerances
        self.assertIsNotNone(known.off)
        self.assertTrue(np.any(known.off))
        self.assertLess(np.abs(known.off).max(), thresholds.WITHIN)
        uses = (*fit.uses, *known.uses)
        (rows,) = evaluator.weighted_residuals([(fit.subject, uses)])
        level = evaluator.noise_level(uses)
        left = float(rows @ rows) / evaluator.count - level
        self.assertAlmostEqual(left, fit.excess / evaluator.count, delta=0.02)
        off = dict(
            zip((n.name for n in known.nuisances), known.off, strict=True)
        )
        for name, delta in (("ring_mass_kg", 0.1), ("force_scale", 0.2)):
            size = next(n for n in nuisances if n.name == name).deviation
            self.assertAlmostEqual(off[name], drawn[name] / size, delta=delta)

    def test_friction_is_told_to_stick_behind_a_leg_that_gives_way(self):
        # A leg half as soft is known to a fifth only.
        true = np.array([1.5e-4, 0.07])
        joint = find_effect("leg_compliance (dry friction)")
        device, _, evaluator = drawn_bench(0.0, (joint, true))
        criterion = criterion_of(device, evaluator)
        card = find_effect("coulomb_friction (without creep)")
        ring = fit_effects(evaluator, [card], [true[1:]])
        found = fit_behind_joints(Linearisation(evaluator, ring), criterion)
        fit = min(found, key=lambda f: f.excess)
        self.assertEqual(fit.name, joint.key)
        self.assertLess(fit.excess, 0.2 * ring.excess)
        np.testing.assert_allclose(fit.values[0] / true, 1.0, atol=0.05)

    def test_a_gain_is_found_where_numbers_were_stretched_to_take_its_place(
        self,
    ):
        # Forces that all scale alike, and their reading that scales back, are
        # a gain of the drives.
        gain, size = find_effect("force_gain"), 0.05
        device, drawn, evaluator = drawn_bench(0.03, (gain, np.array([size])))
        criterion, fit = with_friction(device, evaluator)
        nuisances = criterion.nuisances
        self.assertGreater(fit.stretch, thresholds.WITHIN)
        base = search_beside(evaluator, fit)
        self.assertIsNone(base.tolerances.off)
        lines = Linearisation(evaluator, base)
        self.check_sensitivities(lines)
        candidate = with_one_more(lines, gain, np.array([0.02]))
        self.assertTrue(candidate.step(lines, 5))
        found = refit_within(evaluator, candidate.fit(), nuisances)
        found = [found, *refit_alone(evaluator, [found])][-1]
        self.assertIsNotNone(found.tolerances.off)
        self.assertLess(found.stretch, thresholds.WITHIN)
        # How much of it is the gain's, the ring's mass says: 2 % of it are one
        # tolerance. The reading's whole scale is certain.
        here = found.values[-1][0]
        self.assertAlmostEqual(here, size, delta=0.02)
        off = {
            n.name: t * n.deviation for n, t in estimate_off(evaluator, found)
        }
        whole = size + drawn["force_scale"]
        self.assertAlmostEqual(here + off["force_scale"], whole, delta=0.004)

    def test_a_number_beyond_its_tolerance_is_told_as_the_effect_that_it_is(
        self,
    ):
        scale, size = find_effect("force_scale"), -0.05
        device, drawn, evaluator = drawn_bench(0.03, (scale, np.array([size])))
        criterion, fit = with_friction(device, evaluator)
        self.assertGreater(fit.stretch, 5.0)
        (found,) = fit_beyond(evaluator, fit, criterion)
        self.assertEqual(criterion.findings(found), [scale])
        self.assertLess(found.stretch, thresholds.WITHIN)
        self.assertLess(found.excess, fit.excess + 0.01 * evaluator.count)
        true = size + drawn["force_scale"]
        self.assertAlmostEqual(found.values[-1][0], true, delta=0.01)

        # Drives of as wrong a gain that carry a ring so much lighter do the
        # same: the prior of its mass alone tells which it is.
        others = exchanged(evaluator, criterion, found, [fit, found])
        (gain,) = (f for f in others if f.effects[-1].name == "force_gain")
        self.assertAlmostEqual(gain.values[-1][0], true, delta=0.01)
        self.assertLess(criterion.score(found), criterion.score(gain))
        mass, lighter = (
            {n.name: t * n.deviation for n, t in estimate_off(evaluator, f)}[
                "ring_mass_kg"
            ]
            for f in (found, gain)
        )
        whole = mass + device.twin.scenario.ring.mass
        self.assertAlmostEqual(lighter - mass, true * whole, delta=0.006)

    def test_a_steady_pull_is_a_law_beside_the_friction_that_it_hid(self):
        known, name, pull = terms_for("brace"), "term_ring_x_constant", -0.6
        card = known[name]
        values = np.array([pull, *card.lower[1:]])
        device, _, evaluator = drawn_bench(0.06, (card, values))
        criterion = criterion_of(device, evaluator)
        names = [
            f"term_ring_{k}" for k in ("y_constant", "x_spring", "x_drift")
        ]
        few = {n: known[n] for n in (name, *names)}
        with mock.patch(f"{LawSearch.__module__}.terms_for", lambda _: few):
            laws = LawSearch(evaluator)
        self.assertTrue(laws.explains(criterion, []))
        fit = laws.beside(criterion, criterion.nominal)
        found = {e.name: v[0] for e, v in fit.uses}
        self.assertEqual(len(found), 2)
        self.assertAlmostEqual(found[name], pull, delta=0.05)
        self.assertIn("coulomb_friction", found)
        # Nothing is left that displaced anchors could take.
        self.assertFalse(criterion.is_beyond_level(fit))

    def check_sensitivities(self, lines):
        """A candidate that stands for a number itself sees the fit as whitened
        without it.
        """
        scale = find_effect("force_scale")
        problem = with_one_more(lines, scale, np.array([0.01])).problem
        self.assertIsNot(problem.tolerances, lines.tolerances)
        z = np.append(lines.base.solution.z, 0.01 / problem.scales[-1])
        (residual,) = problem.batch([z], coarse=True)
        found = lines.differentiate(problem, z, residual)
        n, rows = len(z) - 1, lines.rows
        own = lines.base.solution.jacobian[:rows]
        own = lines.base.tolerances.colour(own)
        expected = problem.tolerances.whiten(own)
        size = np.abs(expected).max(axis=0)
        np.testing.assert_allclose(
            found[:rows, :n] / size, expected / size, atol=1e-9
        )


if __name__ == "__main__":
    unittest.main()
