"""What a twin lacks, from measured signals, is what the machine was given."""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.discrepancy.along_runs import follow_law, kind_of_variable
from brace_drake.effects.registry import find_effect
from brace_drake.effects.unknown import terms_for
from brace_drake.scenario.brace import BenchScenario
from tests.synthetic_bench import DEVICE, RATE, record

# Terms with how strong they are, N or as their unit is.
STRONG = {
    "term_ring_y_spring": 4.0,
    "term_ring_y_damper": 2.0,
    "term_torso_y_oscillation": 1.5,
    "term_pads_cube": 12.0,
    "term_force_reading_y_square": 1.0,
    "term_legs_damper": 1.0,
}


class TestLawAlongRuns(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.twin = BenchTwin(BenchScenario())
        cls.subject = np.array([p.nominal for p in cls.twin.subject])
        cls.terms = terms_for(DEVICE)

    def use(self, name):
        card = self.terms[name]
        values = card.starts()[0].astype(float)
        values[0] = STRONG[name]
        return card, values

    def follow(self, uses, law=None):
        """Terms along the runs that the twin records with `uses`."""
        campaign = record(self.twin, self.subject, uses, 5)
        runs = [
            SimpleNamespace(run=r, measured=r.stack(self.twin.channels))
            for r in campaign.runs
        ]
        law = uses if law is None else law
        return follow_law(self.twin, self.subject, law, runs, RATE)

    def test_the_force_that_the_twin_lacks_is_the_term_that_was_put_in(self):
        for name in STRONG:
            with self.subTest(term=name):
                ((_, along),) = self.follow([self.use(name)])
                told = [a for a in along if a.lacks is not None]
                self.assertTrue(told)
                lacks = np.concatenate([a.lacks.ravel() for a in told])
                value = np.concatenate([a.value.ravel() for a in told])
                known = np.isfinite(lacks)
                off = lacks[known] - value[known]
                self.assertLess(np.std(off), 0.2 * np.std(value[known]))

    def test_without_the_term_nothing_is_lacking(self):
        use = self.use("term_ring_y_spring")
        ((_, along),) = self.follow([], [use])
        largest = max(np.abs(a.value).max() for a in along)
        for a in along:
            self.assertLess(np.sqrt(np.mean(a.lacks**2)), 0.1 * largest)

    def test_beside_other_effects_nothing_is_said_of_what_is_lacking(self):
        card = find_effect("force_scale")
        bias = card, np.array([0.01] * len(card.parameters))
        uses = [self.use("term_ring_y_spring"), bias]
        ((_, along),) = self.follow(uses[:1], uses)
        self.assertTrue(all(a.lacks is None for a in along))

    def test_a_term_is_drawn_over_what_it_depends_on(self):
        for name, kind in (
            ("term_ring_y_spring", 0),
            ("term_ring_y_direction", 1),
            ("term_legs_load_square", 2),
            ("term_torso_y_oscillation", 3),
        ):
            self.assertEqual(kind_of_variable(self.terms[name]), kind)


if __name__ == "__main__":
    unittest.main()
