"""Safe motions, and the one that separates rivals best."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.design.next_run import (
    Rival,
    WriteNextRun,
    best_of,
    choose_next_run,
    describe_next,
    open_rivals,
)
from brace_drake.design.planned import planned_floors, planned_runs
from brace_drake.design.separation import (
    choose_best,
    separate_pairs,
)
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import (
    MOTIONS,
    RATE_HZ,
    STANDARD,
    MakeMotion,
)
from brace_drake.devices.motions.limits import exceeded_limit, largest_pad_force
from brace_drake.devices.motions.reference import LoadReference
from brace_drake.devices.subject import bench_subject
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.least_squares import orthonormal_basis
from brace_drake.scenario.brace import BenchScenario
from brace_drake.selection.criterion import Criterion
from tests.known_fits import COUNT, fit_of


def toy_run(x, y_of, slope=1.0):
    """Predictions of two rivals at points x; a subject scales x."""
    first, second = y_of(x)
    return separate_pairs({"a": first, "b": second}, slope * x[:, None])


class TestSeparation(unittest.TestCase):
    def test_it_is_the_residual_of_the_best_fit_of_the_subject(self):
        x = np.array([0.0, 1.0, 2.0, 3.0])
        # y_a - y_b = x^2, the subject takes up phi x: phi = sum x^3 / sum x^2.
        phi = np.sum(x**3) / np.sum(x**2)
        expected = np.sum((x**2 - phi * x) ** 2)
        for slope in (1.0, -40.0):
            (pair,) = toy_run(x, lambda x: (x + x**2, x), slope)
            self.assertAlmostEqual(pair.separation, expected)
            self.assertEqual((pair.first, pair.second), ("a", "b"))

    def test_what_the_subject_takes_up_separates_nothing(self):
        (pair,) = toy_run(np.arange(1.0, 9.0), lambda x: (3.0 * x, -x))
        self.assertAlmostEqual(pair.separation, 0.0)

    def test_what_a_rivals_own_parameters_take_up_separates_nothing(self):
        # Either of two lines, each with a slope of its own; the worse way
        # round counts.
        x, none = np.arange(1.0, 6.0), np.zeros((5, 0))
        predictions = {"a": x + x**2, "b": 3.0 * x}
        own = {"a": (x + x**2)[:, None], "b": x[:, None]}
        basis = [v / np.linalg.norm(v) for v in (x + x**2, x)]
        apart = x**2 - 2.0 * x
        expected = min(apart @ apart - (apart @ u) ** 2 for u in basis)
        (pair,) = separate_pairs(predictions, none, own)
        self.assertAlmostEqual(pair.separation, expected)
        (pair,) = separate_pairs({"a": x, "b": 3.0 * x}, none, {"b": own["b"]})
        self.assertAlmostEqual(pair.separation, 0.0)

    def test_without_sensitivities_it_is_the_plain_distance(self):
        first, second = np.array([1.0, 2.0]), np.array([1.0, 0.0])
        none = np.zeros((2, 3))
        (pair,) = separate_pairs({"a": first, "b": second}, none)
        self.assertAlmostEqual(pair.separation, 4.0)

    def test_copies_among_sensitivities_count_once(self):
        x = np.arange(1.0, 6.0)
        basis = orthonormal_basis(np.column_stack([x, 2.0 * x, 0.0 * x]))
        self.assertEqual(basis.shape, (5, 1))

    def test_the_best_run_is_that_of_the_closed_form(self):
        # Straight line through the origin against x^2, two points 1 and x:
        # T(x) = (x^2 - x)^2 / (1 + x^2), which grows without end beyond 1 and
        # has a second, lower top between 0 and 1 (Atkinson and Fedorov's
        # setting with the slope as the subject).
        grid = np.linspace(0.05, 2.0, 40)
        runs = {
            f"{x:.2f}": toy_run(np.array([1.0, x]), lambda x: (x**2, 0 * x))
            for x in grid
        }
        for x in grid:
            expected = (x**2 - x) ** 2 / (1.0 + x**2)
            self.assertAlmostEqual(runs[f"{x:.2f}"][0].separation, expected)
        self.assertEqual(choose_best(runs), "2.00")
        below = {n: p for n, p in runs.items() if float(n) < 1.0}
        top = max(below, key=lambda n: below[n][0].separation)
        self.assertEqual(choose_best(below), top)

    def test_the_worst_pair_decides(self):
        none, e = np.zeros((2, 0)), np.eye(2)
        lopsided = separate_pairs(
            {"a": 0 * e[0], "b": 9 * e[0], "c": 9 * e[0] + 0.1 * e[1]}, none
        )
        even = separate_pairs({"a": 0 * e[0], "b": e[0], "c": e[1]}, none)
        self.assertAlmostEqual(lopsided[0].separation, 0.01)
        best = choose_best({"lopsided": lopsided, "even": even})
        self.assertEqual(best, "even")
        self.assertIsNone(choose_best({}))


class TestLibrary(unittest.TestCase):
    def test_motions_keep_within_the_limits_for_any_subject(self):
        twin = BenchTwin(BenchScenario(), 1e-3 / 3.0)
        nominal = np.array([p.nominal for p in twin.subject])
        stiffest = np.array([p.upper for p in bench_subject(twin.numbers)])
        for name in MOTIONS:
            motion = MakeMotion(name)
            for subject in (nominal, stiffest):
                with self.subTest(motion=name):
                    log = twin.simulate(twin.motion(motion.run), subject)
                    limit = exceeded_limit(twin, motion, subject, log)
                    self.assertIsNone(limit)

    def test_a_motion_beyond_a_limit_is_told(self):
        twin = BenchTwin(BenchScenario())
        nominal = np.array([p.nominal for p in twin.subject])
        motion, log = MakeMotion("push"), np.zeros((3, 19))
        far = replace(motion, samples=2.0 * motion.samples)
        self.assertIn("20.0 mm", exceeded_limit(twin, far, nominal, log))
        log[1, 13] = 60.0
        self.assertIn("pad force", exceeded_limit(twin, motion, nominal, log))
        log[1, 13], log[2, 4] = 0.0, -130.0
        self.assertIn("leg force", exceeded_limit(twin, motion, nominal, log))

    def test_the_harder_pad_has_half_the_force_and_its_share(self):
        twin = BenchTwin(BenchScenario())
        nominal = np.array([p.nominal for p in twin.subject])
        # k p = 6.4 N: both touch up to |F| = 12.8 N.
        force = np.array([0.0, -4.0, 12.8, -20.0])
        np.testing.assert_allclose(
            largest_pad_force(twin, nominal, force), [6.4, 8.4, 12.8, 20.0]
        )

    def test_derivatives_are_those_of_the_positions(self):
        for name in MOTIONS:
            motion = MakeMotion(name)
            y, dy, ddy = motion.samples.T
            step = 1.0 / RATE_HZ
            with self.subTest(motion=name):
                # Errors of central differences: h^2 / 6 times the third
                # derivative, which stays below 20 m/s^3.
                error = np.gradient(y, step) - dy
                self.assertLess(np.abs(error[1:-1]).max(), 1e-4)
                error = np.gradient(dy, step) - ddy
                self.assertLess(np.abs(error[1:-1]).max(), 5e-3)
                np.testing.assert_allclose(motion.samples[0], 0.0, atol=1e-12)

    def test_an_unknown_motion_is_answered_with_the_closest(self):
        with self.assertRaisesRegex(CampaignError, "did you mean stairs"):
            MakeMotion("stair")

    def test_standard_motions_are_in_the_library(self):
        self.assertLessEqual(set(STANDARD), set(MOTIONS))


def verdict(winner, ambiguous=(), outside=False):
    return SimpleNamespace(
        winner=winner,
        effects=winner.identifiers if winner else (),
        ambiguous_with=ambiguous,
        outside_library=outside,
    )


class TestNextRun(unittest.TestCase):
    def test_rivals_are_the_winner_and_what_is_tied(self):
        fits = [
            fit_of("viscous_leg", 2.0),
            fit_of("hardening", 1.0),
            fit_of("force_lag", 3.0, refined=False),
        ]
        alone = Criterion(fit_of("", 9.0), COUNT)
        for said, expected in (
            (
                verdict(fits[1], ("viscous_leg", "force_lag")),
                ["hardening", "viscous_leg"],
            ),
            (verdict(fits[1]), []),
            (verdict(None, outside=True), ["hardening", "viscous_leg"]),
        ):
            names = [r.name for r in open_rivals(alone, fits, said)]
            self.assertEqual(names, expected)

    def test_nothing_open_needs_no_run(self):
        said = verdict(None)
        self.assertIsNone(choose_next_run(None, None, None, [], said, 0))
        self.assertIsNone(describe_next(said, [], None))

    def test_without_a_safe_motion_one_is_told_in_words(self):
        row = describe_next(verdict(None, outside=True), ["contact"], None)
        self.assertIn("lies in contact", row["why"])
        self.assertIn("stairs", row["motion"])
        row = describe_next(
            verdict(fit_of("hardening", 1.0), ("force_lag",)), [], None
        )
        self.assertIn("separate hardening, force_lag", row["why"])
        self.assertEqual(row["motion"], find_effect("hardening").experiment)

    def test_friction_or_viscosity_is_settled_by_moving(self):
        # Both brake; at rest neither shows, so a hold is worth little.
        twin = BenchTwin(BenchScenario(), 1e-3 / 3.0)
        subject = np.array([p.nominal for p in twin.subject])
        names = ("free_hold", "free_reversal_slow", "free_reversal_fast")
        motions = [MakeMotion(name) for name in names]
        runs = [m.run for m in motions]
        floors = planned_floors(twin, runs, subject, RATE_HZ, 0)
        prepared = planned_runs(twin, runs, floors, RATE_HZ, 0)
        rivals = [
            Rival(name, subject, ((find_effect(key), np.array([value])),))
            for name, key, value in (
                ("a", "viscous_leg", 30.0),
                ("b", "coulomb_friction", 0.3),
                ("c", "viscous_leg", 60.0),
            )
        ]
        evaluator = Evaluator(twin, [], 1)
        found = best_of(evaluator, motions, prepared, rivals[:2])
        # The slower, the less of a viscous force there is beside dry friction.
        self.assertEqual(found.motion.name, "free_reversal_slow")
        self.assertGreater(found.separation, 100.0)
        # Two strengths of one effect are the same explanation.
        same = best_of(evaluator, motions, prepared, rivals[::2])
        self.assertLess(same.separation, 0.02 * found.separation)
        row = describe_next(verdict(None, outside=True), ["actuation"], found)
        self.assertEqual(row["motion"], "free_reversal_slow")
        self.assertEqual(row["file"], "next_run.csv")
        self.assertEqual(row["pairs"][0]["effects"], ["a", "b"])
        with tempfile.TemporaryDirectory() as folder:
            path = WriteNextRun(found, Path(folder))
            head, first = path.read_text().splitlines()[:2]
            self.assertEqual(
                head,
                "time_s,ring2_y_desired_m,ring2_vy_desired_m_s,"
                "ring2_ay_desired_m_s2,contact",
            )
            self.assertEqual(float(first.split(",")[0]), 0.0)
            run = LoadReference(path)
            self.assertFalse(run.contact)
            np.testing.assert_allclose(
                run.channels["ring2_y_desired_m"],
                found.motion.samples[:, 0],
                atol=5e-9,
            )
            self.assertIsNone(WriteNextRun(None, Path(folder)))
            self.assertFalse(path.exists())


if __name__ == "__main__":
    unittest.main()
