"""Which block is named where no effect of the library explains a gap."""

import unittest
from types import SimpleNamespace

from brace_drake.isolation.decision import accused_blocks, suspected_blocks


def row(block, rms, share, threshold=1.2):
    return {
        "block": block,
        "normalised_rms": rms,
        "threshold": threshold,
        "acquitted": rms <= threshold,
        "share": share,
    }


class TestSuspects(unittest.TestCase):
    def test_a_law_of_what_is_left_tells_its_block_before_any_test(self):
        tests = [row("controller", 1.0, 0.0), row("torso", 3.0, 1.0)]
        leg = SimpleNamespace(cause="leg", block="actuation")
        named = SimpleNamespace(effects=(leg,))
        for winner, effects, blocks in (
            (None, (), ["sensing"]),
            (named, ("leg",), ["actuation", "sensing"]),
        ):
            verdict = SimpleNamespace(
                gap=True, winner=winner, effects=effects, outside_library=True
            )
            found = accused_blocks(verdict, None, [], tests, ["sensing"])
            self.assertEqual(found, blocks)

    def test_the_largest_share_is_named_and_the_controller_never(self):
        tests = [row("controller", 9.0, 0.6), row("torso", 3.0, 0.3)]
        tests.append(row("contact", 2.0, 0.1))
        self.assertEqual(suspected_blocks(tests), ["torso"])
        self.assertEqual(suspected_blocks(tests[:1]), [])

    def test_of_blocks_within_their_thresholds_the_nearest_is_named(self):
        tests = [
            row("actuation", 1.13, 0.0, 1.17),
            row("mechanism", 1.15, 0.0, 1.30),
        ]
        self.assertEqual(suspected_blocks(tests), ["actuation"])
