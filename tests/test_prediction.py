"""What causes leave on runs that no fit has seen."""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.identification.gap import RunComparison
from brace_drake.validation.prediction import _MOST, predict_runs
from brace_drake.validation.shrinkage import compare_new_runs

RATE, SAMPLES = 200.0, 2000


class Replays:
    """Runs of noise, which a fit follows but for an error of its own."""

    twin = SimpleNamespace(carried=())

    def __init__(self):
        draw = np.random.default_rng(3)
        self.run = SimpleNamespace(
            measured=draw.standard_normal((SAMPLES, 2)),
            run=SimpleNamespace(time_s=np.arange(SAMPLES) / RATE),
            used=np.array([True, True]),
            floor=SimpleNamespace(rms=np.ones(2)),
        )
        self.replayed = []

    def simulate(self, prepared, subject, uses):
        self.replayed.append(subject)
        if subject is None:
            raise BraceError("the twin breaks down")
        return np.full((SAMPLES, 2), subject)

    def map(self, function, tasks):
        return [function(*task) for task in tasks]


def cause(error, excess=0.0, searched=True, of_runs=()):
    """A fit that is off by `error` floors on every sample."""
    return SimpleNamespace(
        subject=error,
        uses=(),
        within=(),
        excess=excess,
        effects=(SimpleNamespace(run_parameters=of_runs),),
        is_searched=searched,
        refined=searched,
        has_run_parameters=bool(of_runs),
    )


class TestNewRuns(unittest.TestCase):
    def test_without_any_there_is_nothing_to_adapt_to(self):
        nothing = SimpleNamespace(
            prepared=[], twin=Replays.twin, map=lambda function, tasks: []
        )
        breathing = cause(0.0, of_runs=("phase",))
        self.assertEqual(compare_new_runs(nothing, cause(1.0), breathing), [])


class TestPredictions(unittest.TestCase):
    def predict(self, winner, *fits):
        replays = Replays()
        after = None if winner is None else np.zeros((SAMPLES, 2))
        compared = [RunComparison(replays.run, np.ones((SAMPLES, 2)), after)]
        found = predict_runs(replays, compared, winner, fits, 0)
        return found, replays

    def test_the_gap_is_the_root_of_noise_and_error_squared(self):
        winner, rival = cause(0.0), cause(2.0, 1.0)
        (first, second), replays = self.predict(winner, winner, rival)
        self.assertIs(first.fit, winner)
        self.assertAlmostEqual(first.gap, 1.0, delta=0.05)
        self.assertAlmostEqual(second.gap, np.sqrt(5.0), delta=0.05)
        for told in (first, second):
            self.assertLess(told.interval[0], told.gap)
            self.assertGreater(told.interval[1], told.gap)
        # The winner was replayed before.
        self.assertEqual(replays.replayed, [2.0])

    def test_a_twin_that_breaks_down_predicts_nothing_and_stops_nothing(self):
        broken, rival = cause(None, 1.0), cause(2.0, 2.0)
        found, _ = self.predict(None, broken, cause(np.inf, 1.5), rival)
        self.assertEqual([p.fit for p in found], [rival])

    def test_who_was_not_searched_or_has_runs_of_his_own_predicts_nothing(self):
        breath = cause(0.0, of_runs=("phase",))
        found, _ = self.predict(None, cause(0.0, searched=False), breath)
        self.assertEqual(found, [])
        # But the winner was adapted to these runs.
        found, _ = self.predict(breath, breath)
        self.assertEqual([p.fit for p in found], [breath])

    def test_only_those_that_leave_least_are_replayed(self):
        fits = [cause(float(i), excess=-float(i)) for i in range(_MOST + 3)]
        found, _ = self.predict(None, *fits)
        self.assertEqual([p.fit for p in found], fits[: -_MOST - 1 : -1])

    def test_without_runs_there_are_no_predictions(self):
        fit = cause(0.0)
        self.assertEqual(predict_runs(None, [], fit, [fit], 0), [])


if __name__ == "__main__":
    unittest.main()
