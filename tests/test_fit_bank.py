"""Verdicts on the stored fits of blind cases."""

import unittest
from collections import Counter

from tools.fit_bank import BANK, decide_again, is_as_stored, is_right, read_bank


class TestFitBank(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cases = list(read_bank(BANK))

    def test_it_holds_cases_of_every_kind_and_drives_that_stick(self):
        kinds = Counter(record["truth"]["kind"] for record, *_ in self.cases)
        self.assertGreaterEqual(kinds.total(), 100)
        self.assertEqual(set(kinds), {"none", "single", "pair", "outside"})
        sticking = {"coulomb_friction", "stribeck_friction"}
        named = [set(r["truth"]["effects"]) for r, *_ in self.cases]
        self.assertTrue(any(sticking & effects for effects in named))

    def test_stored_fits_lead_to_the_verdicts_that_were_given_with_them(self):
        for record, criterion, fits in self.cases:
            with self.subTest(case=record["name"]):
                verdict = decide_again(record, criterion, fits)
                self.assertTrue(is_as_stored(record, verdict))

    def test_by_far_most_of_the_verdicts_are_right(self):
        right = [
            is_right(record["truth"], decide_again(record, criterion, fits))
            for record, criterion, fits in self.cases
        ]
        self.assertGreater(sum(right), 0.85 * len(right))


if __name__ == "__main__":
    unittest.main()
