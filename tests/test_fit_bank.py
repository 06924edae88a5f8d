"""Verdicts on the stored fits of blind cases."""

import unittest
from collections import Counter

from tools.fit_bank import BANK, TOLERANCES, read_bank
from tools.score_criterion import score


class TestFitBank(unittest.TestCase):
    def assert_decided(self, bank, number, right, clean):
        found = score(bank)
        self.assertEqual(found.number.total(), number)
        self.assertGreaterEqual(found.right.total(), right)
        self.assertGreaterEqual(found.clean.total(), clean)
        self.assertEqual(found.right["none"], found.number["none"])

    def test_it_holds_cases_of_every_kind_and_drives_that_stick(self):
        truths = [record["truth"] for record, *_ in read_bank(BANK)]
        kinds = Counter(truth["kind"] for truth in truths)
        self.assertGreaterEqual(kinds.total(), 100)
        self.assertEqual(set(kinds), {"none", "single", "pair", "outside"})
        sticking = {"coulomb_friction", "stribeck_friction"}
        self.assertTrue(any(sticking & set(t["effects"]) for t in truths))

    def test_stored_cases_are_decided_as_when_the_numbers_were_chosen(self):
        # In sample: it shows a change of behaviour, not how good that is.
        self.assert_decided(BANK, 104, right=92, clean=101)

    def test_a_blind_set_within_tolerances_is_decided_as_it_was(self):
        self.assert_decided(TOLERANCES, 60, right=51, clean=57)


if __name__ == "__main__":
    unittest.main()
