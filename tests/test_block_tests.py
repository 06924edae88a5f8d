"""Blocks fed their recorded inputs: the right one is accused."""

import unittest

from brace_drake.devices.bench.block_tests import bench_tests
from brace_drake.effects.registry import effects_for
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.isolation.block_tests import (
    describe_unchecked,
    run_block_tests,
)
from tests.synthetic_bench import DEVICE, RATE, SyntheticBench, without_torso
from tests.test_leads_back import TREMOR


class TestBlocks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()
        cls.tests = bench_tests(cls.bench.twin, RATE)
        cls.cards = effects_for(DEVICE)

    def accused(self, card):
        """Blocks with a share of the gap of a recording with an effect."""
        evaluator, nominal = self.bench.recording_with_a_gap(card)
        rows = run_block_tests(evaluator, self.tests, nominal, 0)
        return {r["block"]: r["share"] for r in rows if not r["acquitted"]}

    def test_a_drive_that_errs_is_not_laid_on_the_wearer(self):
        # The nominal fit bends contact and torso to cover what drives do.
        shares = self.accused(self.cards["viscous_leg"])
        self.assertEqual(shares, {"actuation": 1.0})

    def test_a_contact_that_errs_is_found(self):
        shares = self.accused(self.cards["relaxation"])
        self.assertGreater(shares["contact"], 0.9)

    def test_a_torso_that_moves_of_itself_is_found(self):
        shares = self.accused(TREMOR)
        self.assertGreater(shares["torso"], 0.9)

    def test_anchors_that_are_off_show_in_the_mechanism(self):
        shares = self.accused(self.cards["anchor_error"])
        self.assertGreater(shares["mechanism"], 0.9)

    def test_a_gauge_that_is_off_shows_in_the_sensing(self):
        shares = self.accused(self.cards["force_bias"])
        self.assertIn("sensing", shares)

    def test_what_lies_between_recorded_channels_is_not_divided(self):
        for edit, lost in (
            (lambda run: run, []),
            (without_torso, ["contact", "torso"]),
        ):
            evaluator = self.bench.evaluator((), edit)
            rows = run_block_tests(
                evaluator, self.tests, fit_nominal(evaluator), 0
            )
            checked = {row["block"] for row in rows}
            blocks = {test.block for test in self.tests}
            self.assertEqual(sorted(blocks - checked), lost)
            said = describe_unchecked(evaluator, self.tests, rows)
            self.assertEqual(len(said), bool(lost))
            for sentence in said:
                self.assertIn("contact and torso: not checked", sentence)
                self.assertIn("torso_y_m", sentence)
                self.assertIn("cannot be divided", sentence)


if __name__ == "__main__":
    unittest.main()
