"""The ladder of blocks fed their recorded inputs accuses the right block."""

import unittest

from brace_drake.effects.registry import effects_for
from brace_drake.gap.bench_ladder import bench_rungs
from brace_drake.gap.ladder import climb
from tests.synthetic_bench import DEVICE, RATE, SyntheticBench
from tests.test_leads_back import TREMOR


class TestLadder(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()
        cls.rungs = bench_rungs(cls.bench.twin, RATE)
        cls.cards = effects_for(DEVICE)

    def accused(self, card):
        """Blocks with a share of the gap of a recording with an effect."""
        evaluator, nominal = self.bench.recording_with_a_gap(card)
        rows = climb(evaluator, self.rungs, nominal, 0)
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


if __name__ == "__main__":
    unittest.main()
