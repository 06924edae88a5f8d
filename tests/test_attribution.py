"""Shares of the blocks in the gap: an honest game, and the right winner."""

import itertools
import unittest
from dataclasses import replace
from unittest import mock

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.noise_floor import NoiseFloor
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.identification.whitening import in_time
from brace_drake.isolation.attribution import attribute, gather
from brace_drake.isolation.shapley import UNEXPLAINED, shapley_values
from brace_drake.isolation.small_errors import attribute_errors
from brace_drake.recording import LoadCampaign
from tests.shared_data import EXAMPLE

BLOCKS = ("actuation", "contact", "torso")


def game(n, value):
    """v of every coalition of n players."""
    return {
        frozenset(c): value(frozenset(c))
        for size in range(n + 1)
        for c in itertools.combinations(range(n), size)
    }


class TestShapley(unittest.TestCase):
    def test_an_additive_game_gives_each_its_own(self):
        own = np.array([0.1, 0.5, 0.0, 0.4])
        values = game(4, lambda s: sum(own[i] for i in s))
        np.testing.assert_allclose(shapley_values(values, 4), own, atol=1e-15)

    def test_the_glove_game_of_the_textbook(self):
        # Players 0 and 1 own a left glove, player 2 a right one.
        values = game(3, lambda s: float(2 in s and len(s) > 1))
        found = shapley_values(values, 3)
        np.testing.assert_allclose(found, [1 / 6, 1 / 6, 4 / 6])

    def test_shares_add_up_and_equal_players_get_the_same(self):
        size = np.array([0.3, 0.3, 0.9, 0.2, 0.0])
        values = game(5, lambda s: np.tanh(sum(size[i] for i in s)))
        found = shapley_values(values, 5)
        self.assertAlmostEqual(found.sum(), np.tanh(size.sum()), places=12)
        self.assertAlmostEqual(found[0], found[1], places=12)
        self.assertAlmostEqual(found[4], 0.0, places=12)


class TestLeastSquares(unittest.TestCase):
    """Residuals made of known parts."""

    def setUp(self):
        self.random = np.random.default_rng(5)
        self.columns = self.random.normal(size=(4, 40, 300))
        self.noise = self.random.normal(size=(40, 300))

    def attribute(self, residual):
        pieces = [
            np.stack([residual[i], *self.columns[:, i]])
            for i in range(len(residual))
        ]
        # One column of the subject, one for each block.
        moments = gather(BLOCKS, [-2, -1, 0, 1, 2], pieces)
        return {r["block"]: r for r in attribute(moments, 0)}

    def test_orthogonal_parts_get_their_sums_of_squares(self):
        _, first, second, _ = self.columns
        rows = self.attribute(6.0 * first + 3.0 * second + self.noise)
        shares = {b: r["share"] for b, r in rows.items()}
        self.assertAlmostEqual(sum(shares.values()), 1.0, places=12)
        # 36 to 9; random columns overlap by 1 / sqrt(12000).
        self.assertAlmostEqual(shares["actuation"], 0.8, delta=0.02)
        self.assertAlmostEqual(shares["contact"], 0.2, delta=0.02)
        self.assertEqual(shares["torso"], 0.0)
        low, high = (rows["contact"][k] for k in ("lower95", "upper95"))
        self.assertTrue(0.15 < low < shares["contact"] < high < 0.25)

    def test_what_the_subject_takes_is_nobodys_share(self):
        subject, _, second, _ = self.columns
        rows = self.attribute(9.0 * subject + 2.0 * second + self.noise)
        # Of the gap the subject's part is gone before blocks are asked.
        self.assertGreater(rows["contact"]["share"], 0.97)

    def test_what_no_block_explains_stays_apart(self):
        # Half of the gap is foreign; so is what is left to the end.
        foreign = 5.0 * self.random.normal(size=(40, 300))
        rows = self.attribute(5.0 * self.columns[3] + foreign + self.noise)
        self.assertAlmostEqual(rows[UNEXPLAINED]["share"], 0.5, delta=0.05)
        self.assertAlmostEqual(rows["torso"]["share"], 0.5, delta=0.05)

    def test_blocks_that_do_the_same_are_named_together(self):
        self.columns[2] = self.columns[3] + 1e-3 * self.columns[2]
        rows = self.attribute(5.0 * self.columns[3] + self.noise)
        (row,) = [r for r in rows.values() if r["share"] > 0.5]
        pair = {row["block"], *row["or"]}
        self.assertEqual(pair, {"contact", "torso"})

    def test_no_gap_has_no_shares(self):
        self.assertEqual(self.attribute(0.5 * self.noise), {})


class TestWhitened(unittest.TestCase):
    def test_a_weighted_residual_keeps_its_squares_in_time(self):
        floor = NoiseFloor(
            np.ones(2), np.array([0.0, 500.0]), np.array([[4.0, 0.25]])
        )
        weights = floor.weights(400, 200.0, highest=50.0)

        class Prepared:
            used = np.array([True, True])

        Prepared.weights = weights
        random = np.random.default_rng(1)
        weighted = random.normal(size=201 * 2)
        series = in_time(Prepared, weighted)
        self.assertEqual(series.shape, (201, 2))
        self.assertAlmostEqual(np.sum(series**2), weighted @ weighted)


class TestBench(unittest.TestCase):
    """One effect of the twin itself, switched on in one block."""

    # Effect and values in the order of its parameters; each a clear gap.
    CASES = (
        ("force_bias", (0.4,)),
        ("relaxation", (4000.0, 1.0)),
        ("viscous_leg", (30.0,)),
        ("ring_mass", (0.3,)),
    )

    @classmethod
    def setUpClass(cls):
        campaign = LoadCampaign(EXAMPLE)
        device = MakeDevice(campaign)
        cls.twin, cls.errors = device.twin, device.small_errors()
        nominal = np.array([p.nominal for p in cls.twin.subject])
        floors, _ = estimate_floors(cls.twin, campaign, nominal, 0)
        cls.prepared = prepare_runs(
            cls.twin, campaign.split("fit")[:2], floors, campaign.rate_hz, 0
        )
        cls.nominal = nominal

    def test_the_block_with_the_effect_has_the_largest_share(self):
        for name, values in self.CASES:
            effect = find_effect(name)
            with self.subTest(effect=name):
                rows = self.rows((effect, np.array(values)))
                shares = {r["block"]: r["share"] for r in rows}
                self.assertAlmostEqual(sum(shares.values()), 1.0, places=9)
                self.assertEqual(max(shares, key=shares.get), effect.block)

    def test_a_loose_prior_of_the_subject_changes_no_share(self):
        use = find_effect("force_bias"), np.array([0.4])
        subject = self.twin.subject
        loose = [replace(p, deviation=1e3 * p.nominal) for p in subject]
        with mock.patch.object(self.twin, "subject", tuple(loose)):
            known = self.rows(use)
        for row, free in zip(known, self.rows(use), strict=True):
            self.assertAlmostEqual(row["share"], free["share"], places=4)

    def rows(self, use):
        prepared = []
        for i, p in enumerate(self.prepared):
            measured = self.twin.simulate(
                p.motion, self.nominal, (use,), np.random.default_rng([3, i])
            )
            prepared.append(replace(p, measured=measured))
        evaluator = Evaluator(self.twin, prepared, 1)
        nominal = fit_nominal(evaluator)
        return attribute_errors(evaluator, nominal, self.errors, 0)


if __name__ == "__main__":
    unittest.main()
