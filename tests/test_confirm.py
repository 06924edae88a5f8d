"""Validation has the last word, on runs whose replays are known."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.document.document import confirmed
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import decide
from brace_drake.validation.causes import one_of_each
from brace_drake.validation.confirm import confirm
from brace_drake.validation.new_runs import weigh_on_new_runs
from tests.known_fits import COUNT, fit_of

RATE, SAMPLES = 200.0, 2000


class Runs:
    """One run of noise; a fit's subject is what its twin is off, in floors."""

    twin = SimpleNamespace(carried=(), has_loop=False)

    def __init__(self, empty=False):
        run = SimpleNamespace(
            measured=np.random.default_rng(3).standard_normal((SAMPLES, 2)),
            run=SimpleNamespace(time_s=np.arange(SAMPLES) / RATE),
            used=np.array([True, True]),
            floor=SimpleNamespace(rms=np.ones(2)),
        )
        self.prepared = [] if empty else [run]

    def simulate(self, prepared, subject, uses):
        if np.isnan(subject[0]):
            raise BraceError("the twin breaks down")
        return np.full((SAMPLES, 2), subject[0])

    def map(self, function, tasks):
        return [function(*task) for task in tasks]


class WeighedRuns:
    """Validation runs on which each fit leaves a known misfit, its subject;
    where that is NaN its twin breaks down.
    """

    prepared, count = [None], 1000

    def excess(self, rows, uses):
        return float(rows @ rows) - self.count

    def weighted_residuals(self, points):
        return [
            None
            if np.isnan(subject[0])
            else np.full(self.count, np.sqrt(1.0 + subject[0]))
            for subject, _ in points
        ]


def off(keys, misfit, there):
    """A fit that leaves `misfit`, and is so many floors off on new runs."""
    return replace(fit_of(keys, misfit), subject=np.array([there]))


class TestCauses(unittest.TestCase):
    def test_of_the_same_effects_the_one_led_furthest_is_a_cause(self):
        early = fit_of("relaxation+force_bias", 0.1, refined=False)
        late = fit_of("force_bias+relaxation", 0.2)
        best = fit_of("relaxation+force_bias", 0.15)
        other = fit_of("relaxation", 3.0)
        criterion = Criterion(fit_of("", 9.0), COUNT)
        found = one_of_each(criterion, [early, late, other, best], None)
        self.assertEqual(found, [best, other])
        found = one_of_each(criterion, [early, late, other, best], late)
        self.assertEqual(found, [late, other])


class TestNewRuns(unittest.TestCase):
    def weigh(self, nominal, *fits):
        criterion = Criterion(nominal, COUNT)
        return weigh_on_new_runs(WeighedRuns(), criterion, fits)

    def test_what_new_runs_leave_is_half_of_what_is_left_on_new_motions(self):
        fit = off("relaxation", 0.2, 0.6)
        early = replace(fit, refined=False)
        criterion, (found, same) = self.weigh(off("", 9.0, 5.0), fit, early)
        self.assertAlmostEqual(found.held_out, 0.4)
        self.assertAlmostEqual(criterion.nominal.held_out, 7.0)
        # What was not led to its end can not win: it costs no replay.
        self.assertIs(same, early)

    def test_of_one_motion_new_runs_alone_tell_of_others(self):
        fit = replace(off("relaxation", 0.2, 0.6), held_out=None)
        _, (found,) = self.weigh(off("", 9.0, 5.0), fit)
        self.assertAlmostEqual(found.held_out, 0.6)

    def test_a_twin_that_breaks_down_there_is_weighed_as_before(self):
        fit = off("relaxation", 0.2, np.nan)
        _, (found,) = self.weigh(off("", 9.0, 5.0), fit)
        self.assertIs(found, fit)

    def test_a_rival_that_new_runs_prefer_beyond_doubt_is_named(self):
        imitates = off("hysteresis", 0.1, 4.0)
        true = off("relaxation", 0.2, 0.1)
        nominal = off("", 9.0, 20.0)
        criterion = Criterion(nominal, COUNT)
        before = decide(criterion, [imitates, true])
        self.assertEqual(before.effects, ("hysteresis",))
        criterion, fits = self.weigh(nominal, imitates, true)
        after = decide(criterion, fits)
        self.assertEqual(after.effects, ("relaxation",))
        self.assertGreater(after.probability, 0.5)


class TestConfirm(unittest.TestCase):
    def confirm(self, nominal, *fits, empty=False):
        """What new runs leave of the verdict on fits."""
        criterion = Criterion(nominal, COUNT)
        self.before = decide(criterion, fits)
        return confirm(Runs(empty), criterion, self.before, fits, 0)

    def check_confirmed(self, found, expected):
        """Of the document of a diagnosis."""
        shrinkage = None
        if found.compared:
            repaired = found.compared[0].after is not None
            shrinkage = {"closed": 0.9 if repaired else None, "before": 3.0}
        criterion = SimpleNamespace(level=0.1)
        d = SimpleNamespace(
            verdict=found.verdict, shrinkage=shrinkage, criterion=criterion
        )
        self.assertIs(confirmed(d), expected)

    def test_an_effect_that_makes_new_runs_better_is_confirmed(self):
        found = self.confirm(off("", 9.0, 3.0), off("relaxation", 0.0, 0.1))
        self.assertIs(found.verdict, self.before)
        self.assertGreater(found.closed["relaxation"].interval[0], 0.9)
        self.check_confirmed(found, True)

    def test_an_effect_that_makes_new_runs_worse_is_withdrawn(self):
        found = self.confirm(off("", 9.0, 3.0), off("relaxation", 0.0, 3.5))
        verdict = found.verdict
        self.assertEqual((verdict.effects, verdict.winner), ((), None))
        self.assertTrue(verdict.gap and verdict.outside_library)
        self.assertIn("relaxation would change the gap", verdict.contradicted)
        self.assertLess(verdict.probability, 0.5)
        self.assertIsNone(found.compared[0].after)
        self.check_confirmed(found, False)

    def test_one_of_two_is_withdrawn_by_itself_and_the_other_stays(self):
        one = off("relaxation", 0.6, 0.5)
        both = off("relaxation+backlash (play)", 0.0, 1.5)
        found = self.confirm(off("", 50.0, 5.0), one, both)
        self.assertEqual(set(self.before.effects), {"relaxation", "backlash"})
        verdict = found.verdict
        self.assertEqual(verdict.effects, ("relaxation",))
        self.assertIs(verdict.winner, one)
        self.assertTrue(
            verdict.contradicted.startswith("backlash (actuation) makes")
        )
        (support,) = verdict.supported
        self.assertLess(verdict.probability, 0.5)
        self.assertGreaterEqual(support.probability, verdict.probability)
        self.assertEqual(set(found.closed), {"relaxation"})
        self.assertFalse(found.closed["relaxation"].is_harm)
        self.check_confirmed(found, False)

    def test_in_the_place_of_what_is_withdrawn_nothing_else_is_named(self):
        one = off("relaxation", 0.6, 0.5)
        both = off("relaxation+backlash (play)", 0.0, 1.5)
        rival = off("relaxation+force_bias", 0.02, 0.1)
        found = self.confirm(off("", 50.0, 5.0), both, one, rival)
        self.assertIn("backlash", self.before.effects)
        self.assertEqual(found.verdict.effects, ("relaxation",))

    def test_where_the_repaired_twin_breaks_down_nothing_is_confirmed(self):
        fit = off("relaxation", 0.0, np.nan)
        found = self.confirm(off("", 9.0, 3.0), fit)
        self.assertIs(found.verdict, self.before)
        self.assertIsNone(found.closed["relaxation"].interval)
        self.check_confirmed(found, None)

    def test_without_new_runs_nothing_is_confirmed(self):
        fit = off("relaxation", 0.0, 0.0)
        found = self.confirm(off("", 9.0, 3.0), fit, empty=True)
        self.assertIs(found.verdict, self.before)
        self.check_confirmed(found, None)

    def test_no_gap_is_withdrawn_where_new_runs_are_off(self):
        self.assertFalse(self.confirm(off("", 0.0, 0.1)).verdict.contradicted)
        found = self.confirm(off("", 0.0, 2.0)).verdict
        self.assertTrue(found.gap)
        self.assertIn("times the floor off", found.contradicted)


if __name__ == "__main__":
    unittest.main()
