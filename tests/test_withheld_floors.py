"""Sizes of faults in noise floors, where they can be told in advance."""

import unittest

import numpy as np

from brace_drake.withheld.cases import build_case
from brace_drake.withheld.faults import FAULTS
from brace_drake.withheld.floors import measure
from brace_drake.withheld.make import size_of
from brace_drake.withheld.simulator import make_motions


class TestPair(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rng = np.random.default_rng(0)
        # Free of the torso, where a drifting sensor moves nothing but the ring
        # along with its reading: next to a heavier ring it adds what it does
        # alone.
        cls.motions = [m for m in make_motions(rng) if not m.contact][:1]
        names = ("ring_mass", "force_drift")
        pair = tuple(f for f in FAULTS if f.name in names)
        cls.case = build_case(rng, "pair", pair, "medium", lambda _: 8.0)
        cls.sizes = size_of(cls.case, cls.motions)

    def test_each_of_two_that_do_not_meet_adds_what_it_is_alone(self):
        first, second = self.case.faults
        for fault, other in ((first, second), (second, first)):
            alone = measure(
                self.motions,
                self.case.subject,
                self.case.background,
                self.case.without(other),
                refit=False,
            )
            beside = self.sizes["beside"][fault.name]["rms"]
            self.assertGreater(beside, 1.0)
            self.assertAlmostEqual(beside / alone.rms, 1.0, delta=0.02)

    def test_a_subject_that_is_not_touched_takes_nothing_of_a_gap(self):
        whole = self.sizes["faults"]
        self.assertAlmostEqual(whole["refitted"], whole["rms"])


if __name__ == "__main__":
    unittest.main()
