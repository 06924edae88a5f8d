"""Shares of repaired blocks on recordings whose gap is known."""

import itertools
import unittest
from types import SimpleNamespace
from unittest import mock

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.isolation.repair_shares import share_repairs
from brace_drake.isolation.shapley import UNEXPLAINED, shapley_values
from brace_drake.selection.search.candidate import make_candidate
from brace_drake.selection.search.linearisation import Linearisation
from tests.pad_recordings import make_campaign, relaxing
from tests.synthetic_bench import SyntheticBench

DRIFT = 2.0e-2


def drifting(motion, time):
    """A relaxing tissue under a gauge that drifts, N/s, as it warms up."""
    return relaxing(motion, time) + DRIFT * time


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


class TestShares(unittest.TestCase):
    def shares(self, force_of, names, rivals=()):
        campaign = make_campaign(force_of)
        twin = MakeDevice(campaign).twin
        subject = np.array([p.nominal for p in twin.subject])
        floors, _ = estimate_floors(twin, campaign, subject, 0)
        runs = prepare_runs(
            twin, campaign.split("fit"), floors, campaign.rate_hz, 0
        )
        evaluator = Evaluator(twin, runs, 1)
        nominal = fit_nominal(evaluator)
        cards = [find_effect(name) for name in names]
        starts = [next(iter(card.starts())) for card in cards]
        winner = fit_effects(evaluator, cards, starts)
        rows = share_repairs(evaluator, nominal, winner, rivals, 0)
        return {row["block"]: row for row in rows}

    def test_one_block_gets_all_that_its_repair_takes(self):
        rows = self.shares(relaxing, ["relaxation"], ["force_drift"])
        self.assertEqual(list(rows), ["contact", UNEXPLAINED])
        self.assertGreater(rows["contact"]["share"], 0.99)
        self.assertEqual(rows["contact"]["or"], ["sensing"])
        total = sum(row["share"] for row in rows.values())
        self.assertAlmostEqual(total, 1.0, places=12)

    def test_of_no_gap_there_are_no_shares(self):
        noise = SimpleNamespace(solution=SimpleNamespace(residual=None))
        with mock.patch(
            "brace_drake.isolation.repair_shares._excess_pieces",
            lambda *_: {frozenset(): np.array([0.5, -1.0])},
        ):
            card = SimpleNamespace(block="contact")
            winner = SimpleNamespace(effects=[card])
            self.assertEqual(share_repairs(None, noise, winner, (), 0), [])

    def test_noise_that_dithers_leave_is_no_part_of_the_gap(self):
        card = find_effect("coulomb_friction")
        bench = SyntheticBench()
        evaluator, nominal = bench.recording_with_a_gap(card)
        start = bench.values_of_a_gap(card)
        winner = fit_effects(evaluator, [card], [start])
        rows = share_repairs(evaluator, nominal, winner, (), 0)
        left = {row["block"]: row["share"] for row in rows}[UNEXPLAINED]
        rest = max(0.0, winner.excess) / nominal.excess
        self.assertAlmostEqual(left, rest, delta=0.01)

    def test_an_effect_without_spread_is_repaired_beside_one_with_it(self):
        # Of anchors and a dead zone the dead zone alone is a coalition.
        bench, card = SyntheticBench(), find_effect("force_deadzone")
        evaluator = bench.evaluator(())
        nominal = fit_nominal(evaluator)
        base, values = Linearisation(evaluator, nominal), card.starts()[0]
        runners = [
            make_candidate(base, [card], [values], nominal.subject, spread)
            for spread in (None, 1e-4)
        ]
        np.testing.assert_array_equal(runners[0].residual, runners[1].residual)

    def test_a_block_that_is_right_adds_nothing_to_the_other(self):
        rows = self.shares(relaxing, ["relaxation", "force_drift"])
        self.assertGreater(rows["contact"]["share"], 0.8)
        self.assertGreater(rows["contact"]["alone"], 0.99)

    def test_two_blocks_share_the_gap_and_nothing_is_left(self):
        rows = self.shares(drifting, ["relaxation", "force_drift"])
        self.assertEqual(list(rows), ["contact", "sensing", UNEXPLAINED])
        total = sum(row["share"] for row in rows.values())
        self.assertAlmostEqual(total, 1.0, places=12)
        self.assertLess(rows[UNEXPLAINED]["share"], 0.01)
        for block in ("contact", "sensing"):
            row = rows[block]
            self.assertLess(row["alone"], 1.0)
            self.assertLessEqual(row["lower95"], row["share"])
            self.assertGreaterEqual(row["upper95"], row["share"])


if __name__ == "__main__":
    unittest.main()
