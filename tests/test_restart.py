"""Searches that begin again, on a sum of squares with two valleys."""

import unittest
from dataclasses import dataclass, replace
from types import SimpleNamespace
from unittest import mock

import numpy as np
from brace_drake.selection.search.joint_refit import is_caught, restart

from brace_drake.effects.registry import find_effect
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search import joint_refit

EVALUATOR = SimpleNamespace(count=100)
NULL = SimpleNamespace(misfit_threshold=0.1, least_gain=lambda n: 0.03)


@dataclass(frozen=True)
class Fit:
    """What of a fit a restart looks at."""

    subject: np.ndarray
    values: tuple
    excess: float
    names: tuple = ("force_bias", "saturation (drive)")
    refined: bool = True
    is_scattered: bool = True
    is_searched: bool = True
    freedom: int = 2

    @property
    def effects(self):
        return tuple(find_effect(name) for name in self.names)

    @property
    def is_flexible(self):
        return any(e.is_flexible for e in self.effects)

    @property
    def sticks(self):
        return any(e.sticks for e in self.effects)

    @property
    def uses(self):
        return tuple(zip(self.effects, self.values, strict=True))


def caught(excess, names=Fit.names, searched=True):
    return Fit(
        np.ones(6),
        (np.array([0.1]), np.array([8.0])),
        excess,
        names,
        is_searched=searched,
    )


def downhill(evaluator, fit):
    """A valley of 342 squares, and one of 8 beyond a ridge at 1.1."""
    is_over = fit.subject[0] > 1.1 or fit.subject[0] < 0.9
    return replace(fit, excess=8.0 if is_over else 342.0, refined=True)


class TestRestart(unittest.TestCase):
    def test_a_search_that_was_caught_comes_out_of_its_valley(self):
        with mock.patch.object(joint_refit, "try_refine", downhill):
            outcomes = [restart(EVALUATOR, caught(342.0), s) for s in range(20)]
        # Misses 0.1 of a scatter of 0.2 three times: 0.383 ** 3 = 0.06.
        self.assertGreaterEqual(sum(len(o) for o in outcomes), 16)
        for found in (f for o in outcomes for f in o):
            self.assertEqual(found.excess, 8.0)

    def test_where_there_is_one_valley_nothing_is_found(self):
        def stay(evaluator, fit):
            return replace(fit, excess=200.0, refined=True)

        with mock.patch.object(joint_refit, "try_refine", stay):
            self.assertEqual(restart(EVALUATOR, caught(342.0), 0), [])

    def test_a_seed_gives_the_same_places(self):
        starts = []

        def look(evaluator, fit):
            starts.append(np.concatenate([fit.subject, *fit.values]))
            return fit

        with mock.patch.object(joint_refit, "try_refine", look):
            for seed in (1, 1, 2):
                restart(EVALUATOR, caught(342.0), seed)
        first, second, other = np.split(np.array(starts), 3)
        np.testing.assert_array_equal(first, second)
        self.assertGreater(np.abs(first - other).max(), 0.0)

    def test_only_pairs_that_nearly_explain_are_taken_for_caught(self):
        gap = Fit(np.ones(6), (), 110_000.0, ())
        criterion = Criterion(gap, 100, True, null=NULL)
        for excess, names, searched, want in (
            (342.0, Fit.names, True, True),
            (342.0, Fit.names, False, False),
            (50.0, Fit.names, True, False),
            (60_000.0, Fit.names, True, False),
            (342.0, ("coulomb_friction", "force_bias"), True, False),
            (342.0, ("hysteresis", "force_bias"), True, True),
            (342.0, ("anchor_error", "force_bias"), True, False),
        ):
            with self.subTest(excess=excess, names=names, searched=searched):
                pair = caught(excess, names, searched)
                self.assertEqual(is_caught(criterion, pair), want)


if __name__ == "__main__":
    unittest.main()
