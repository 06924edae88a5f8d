"""What an imposed motion shows where drives stick, and friction beside it."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from brace_drake.selection.search.friction import fit_frictions

from brace_drake.devices.bench.imposed_twin import GuidedBenchTwin
from brace_drake.effects.registry import find_effect
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.isolation.imposed_motion import (
    explain_imposed_motion,
    fit_imposed_motion,
)
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search.linearisation import Linearisation
from tests.synthetic_bench import SyntheticBench, record, searched

FRICTION = find_effect("coulomb_friction")
RELAXATION = find_effect("relaxation"), np.array([4000.0, 0.8])


def quiet(what, share):
    """Says nothing."""


def with_limit(evaluator, limit):
    """A criterion by whose noise a misfit up to the limit is none."""
    null = SimpleNamespace(misfit_threshold=limit)
    return Criterion(None, evaluator.count, True, null=null)


class TestImposedMotion(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()
        twin = cls.bench.twin
        cls.guided = GuidedBenchTwin(twin.scenario, twin.time_step)
        cls.stuck = FRICTION, np.array([0.8])

    def side(self, *uses, edit=lambda run: run):
        campaign = record(self.bench.twin, self.bench.subject, uses, 97)
        runs = tuple(edit(run) for run in campaign.runs)
        return fit_imposed_motion(
            self.guided, replace(campaign, runs=runs), 2, 0
        )

    def test_friction_of_the_drives_is_no_gap_and_hides_no_subject(self):
        side = self.side(self.stuck)
        self.assertLess(abs(side.nominal.excess / side.evaluator.count), 0.12)
        self.assertTrue(side.row()["acquitted"])
        found = explain_imposed_motion(side, 0)
        self.assertEqual(found.effects, ())
        loop = fit_nominal(self.bench.evaluator([self.stuck]))
        off, lost = (
            abs(np.log(fit.subject / self.bench.subject))
            for fit in (found, loop)
        )
        self.assertLess(off.max(), 0.15)
        self.assertGreater(lost.max(), 2.0 * off.max())

    def test_an_effect_of_the_contact_is_named_beside_friction(self):
        side = self.side(self.stuck, RELAXATION)
        self.assertFalse(side.row()["acquitted"])
        found = explain_imposed_motion(side, 0)
        self.assertEqual(found.identifiers, ("relaxation",))
        np.testing.assert_allclose(found.values[0], RELAXATION[1], rtol=0.1)

    def test_friction_is_found_beside_it_with_what_it_shows_kept(self):
        seen = explain_imposed_motion(self.side(self.stuck, RELAXATION), 0)
        evaluator = self.bench.evaluator([self.stuck, RELAXATION])
        ground = Linearisation(evaluator, fit_nominal(evaluator))
        alone = searched(ground, [FRICTION])
        frictions = with_limit(evaluator, 0.1).sticking(alone)
        self.assertEqual([f.name for f in frictions], ["coulomb_friction"])
        pair, *_ = fit_frictions(evaluator, frictions, seen, [FRICTION], quiet)
        self.assertEqual(pair.identifiers, ("relaxation", "coulomb_friction"))
        np.testing.assert_allclose(pair.values[0], seen.values[0])
        np.testing.assert_allclose(pair.subject, seen.subject)
        self.assertAlmostEqual(pair.values[1][0], 0.8, delta=0.08)
        self.assertLess(pair.excess, 0.5 * alone[0].excess)

    def test_no_friction_is_beside_what_explains_without_one(self):
        explained = self.bench.evaluator([self.stuck])
        ground = Linearisation(explained, fit_nominal(explained))
        fits = searched(ground, [FRICTION])
        enough = fits[0].excess / explained.count + 0.01
        self.assertEqual(with_limit(explained, enough).sticking(fits), [])

    def test_without_the_way_or_a_touch_it_is_not_looked_at(self):
        def blind(run):
            names = [f"leg{k}_length_m" for k in range(1, 7)]
            kept = {k: v for k, v in run.channels.items() if k not in names}
            return replace(run, channels=kept)

        self.assertIsNone(self.side(edit=blind))
        self.assertIsNone(self.side(edit=lambda r: replace(r, contact=False)))
        self.assertIsNone(fit_imposed_motion(None, None, 1, 0))

    def test_effects_of_drives_ring_and_encoders_are_not_on_it(self):
        names = ("coulomb_friction", "ring_mass", "encoder_offset", "backlash")
        for name in names:
            self.assertFalse(find_effect(name).answers_motion, name)
        for name in ("relaxation", "breathing", "reflex", "force_bias"):
            self.assertTrue(find_effect(name).answers_motion, name)


if __name__ == "__main__":
    unittest.main()
