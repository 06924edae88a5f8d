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


def explained(**shares):
    return [{"block": b, "explained": share} for b, share in shares.items()]


class TestSuspects(unittest.TestCase):
    def test_a_law_of_what_is_left_tells_its_block_before_any_test(self):
        tests = [row("controller", 1.0, 0.0), row("torso", 3.0, 1.0)]
        leg = SimpleNamespace(name="leg", block="actuation")
        named = SimpleNamespace(effects=(leg,))
        for winner, effects, blocks in (
            (None, (), ["sensing"]),
            (named, ("leg",), ["actuation", "sensing"]),
        ):
            verdict = SimpleNamespace(
                gap=True, winner=winner, effects=effects, outside_library=True
            )
            found = accused_blocks(verdict, None, [], tests, {}, ["sensing"])
            self.assertEqual(found, blocks)

    def test_the_largest_share_is_named_and_the_controller_never(self):
        tests = [row("controller", 9.0, 0.6), row("torso", 3.0, 0.3)]
        tests.append(row("contact", 2.0, 0.1))
        self.assertEqual(suspected_blocks(tests, []), ["torso"])
        self.assertEqual(suspected_blocks(tests[:1], []), [])

    def test_of_blocks_within_their_thresholds_the_nearest_is_named(self):
        tests = [
            row("actuation", 1.13, 0.0, 1.17),
            row("mechanism", 1.15, 0.0, 1.30),
        ]
        self.assertEqual(suspected_blocks(tests, []), ["actuation"])

    def test_of_blocks_within_their_thresholds_small_errors_tell_which(self):
        tests = [
            row("actuation", 1.13, 0.0, 1.17),
            row("mechanism", 1.15, 0.0, 1.30),
        ]
        shares = [
            {"block": "actuation", "share": 0.2},
            {"block": "mechanism", "share": 0.3},
            {"block": "none of these", "share": 0.5},
        ]
        found = suspected_blocks(tests, [], attribution=shares)
        self.assertEqual(found, ["mechanism"])
        tests[0] = row("actuation", 1.3, 1.0, 1.17)
        found = suspected_blocks(tests, [], attribution=shares)
        self.assertEqual(found, ["actuation"])
        for entry in shares[:2]:
            entry["share"] = 0.0
        tests[0] = row("actuation", 1.13, 0.0, 1.17)
        found = suspected_blocks(tests, [], attribution=shares)
        self.assertEqual(found, ["actuation"])

    def test_drives_that_seem_wrong_are_asked_for_the_shape_of_it(self):
        tests = [row("actuation", 24.0, 1.0), row("torso", 1.0, 0.0)]
        for shares, block in (
            (explained(actuation=0.5, mechanism=0.99), "mechanism"),
            (explained(actuation=0.5, mechanism=0.8), "actuation"),
            ([], "actuation"),
        ):
            self.assertEqual(suspected_blocks(tests, shares), [block])

    def test_a_side_that_holds_on_the_way_of_the_ring_is_acquitted(self):
        tests = [row("actuation", 1.3, 0.3), row("torso", 1.5, 0.7)]
        tests += [row("contact", 1.0, 0.0), row("sensing", 1.0, 0.0)]
        for rms, block in ((1.15, "actuation"), (1.25, "actuation")):
            side = row("side", rms, None) | {"acquitted": rms <= 1.2}
            self.assertEqual(suspected_blocks(tests, [], side), [block])
        side = row("side", 1.6, None) | {"acquitted": False}
        self.assertEqual(suspected_blocks(tests, [], side), ["torso"])
        self.assertEqual(suspected_blocks(tests, []), ["torso"])

    def test_a_reading_that_holds_on_the_way_of_the_ring_is_acquitted(self):
        tests = [row("actuation", 1.1, 0.0, 2.5), row("sensing", 1.9, 0, 2.2)]
        side = row("side", 1.1, None) | {"acquitted": True}
        self.assertEqual(suspected_blocks(tests, [], side), ["actuation"])
        side = row("side", 2.9, None) | {"acquitted": False}
        self.assertEqual(suspected_blocks(tests, [], side), ["sensing"])

    def test_what_drives_and_ring_do_not_show_is_on_the_contacts_side(self):
        tests = [row("actuation", 0.98, 0.0), row("mechanism", 1.25, 0, 1.28)]
        tests += [row("contact", 0.96, 0.0), row("torso", 0.98, 0.0)]
        side = row("side", 1.5, None) | {"acquitted": False}
        self.assertEqual(suspected_blocks(tests, [], side), ["torso"])
        side["acquitted"] = True
        self.assertEqual(suspected_blocks(tests, [], side), ["mechanism"])

    def test_errors_of_the_ring_do_not_clear_another_block(self):
        tests = [row("torso", 5.0, 1.0)]
        shares = explained(actuation=0.2, mechanism=1.0)
        found = suspected_blocks(tests, shares)
        self.assertEqual(found, ["torso"])
