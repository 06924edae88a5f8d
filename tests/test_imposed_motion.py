"""What an imposed motion shows where drives stick."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.devices.bench.drawn import draw_tolerances, uses_of_draws
from brace_drake.devices.bench.imposed_twin import GuidedBenchTwin
from brace_drake.devices.bench.tolerances import bench_tolerances
from brace_drake.effects.registry import find_effect
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.isolation.imposed_motion import fit_imposed_motion
from brace_drake.selection.thresholds import WITHIN
from tests.synthetic_bench import SyntheticBench, record

FRICTION = find_effect("coulomb_friction")
RELAXATION = find_effect("relaxation"), np.array([4000.0, 0.8])


class TestImposedMotion(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()
        twin = cls.bench.twin
        cls.guided = GuidedBenchTwin(twin.scenario, twin.time_step)
        cls.stuck = FRICTION, np.array([0.8])

    def side(self, *uses, edit=lambda run: run, nuisances=()):
        campaign = record(self.bench.twin, self.bench.subject, uses, 97)
        runs = tuple(edit(run) for run in campaign.runs)
        return fit_imposed_motion(
            self.guided, replace(campaign, runs=runs), 2, 0, nuisances
        )

    def test_friction_of_the_drives_is_no_gap_and_hides_no_subject(self):
        side = self.side(self.stuck)
        self.assertLess(abs(side.nominal.excess / side.evaluator.count), 0.12)
        self.assertTrue(side.row()["acquitted"])
        loop = fit_nominal(self.bench.evaluator([self.stuck]))
        off, lost = (
            abs(np.log(fit.subject / self.bench.subject))
            for fit in (side.nominal, loop)
        )
        self.assertLess(off.max(), 0.15)
        self.assertGreater(lost.max(), 2.0 * off.max())

    def test_an_effect_of_the_contact_is_a_gap_beside_friction(self):
        self.assertFalse(self.side(self.stuck, RELAXATION).row()["acquitted"])

    def test_numbers_within_their_tolerances_are_no_gap_there(self):
        scenario = self.guided.scenario
        drawn = uses_of_draws(scenario, draw_tolerances(scenario, 3))
        known = bench_tolerances(scenario)
        exact = self.side(self.stuck, *drawn)
        self.assertFalse(exact.row()["acquitted"])
        within = self.side(self.stuck, *drawn, nuisances=known)
        self.assertTrue(within.row()["acquitted"])
        self.assertLess(within.nominal.stretch, WITHIN)
        # What the numbers cannot do stays.
        more = self.side(self.stuck, RELAXATION, *drawn, nuisances=known)
        self.assertFalse(more.row()["acquitted"])

    def test_without_the_way_or_a_touch_it_is_not_looked_at(self):
        def blind(run):
            names = [f"leg{k}_length_m" for k in range(1, 7)]
            kept = {k: v for k, v in run.channels.items() if k not in names}
            return replace(run, channels=kept)

        self.assertIsNone(self.side(edit=blind))
        self.assertIsNone(self.side(edit=lambda r: replace(r, contact=False)))
        self.assertIsNone(fit_imposed_motion(None, None, 1, 0))


if __name__ == "__main__":
    unittest.main()
