"""Policies beside controllers: same numbers as env and diagram, intervals."""

import csv
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np

from brace_drake.core.errors import BraceError, PolicyError
from brace_drake.core.parallel import open_workers
from brace_drake.core.resources import policy_path
from brace_drake.experiments import evaluate, rollouts
from brace_drake.experiments.compare import LoadPush, compare_controllers
from brace_drake.experiments.evaluation_words import _on_nominal_need
from brace_drake.experiments.rollouts import (
    SAMPLES,
    Benchmark,
    Controller,
    search_constant,
)
from brace_drake.experiments.tables import (
    TABLE_1_RLPIC,
    median_interval,
    share_interval,
    student_interval,
)
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.episode import run_episode
from brace_drake.learning.policy import LoadPolicy, SavePolicy
from brace_drake.learning.rewards import improved
from brace_drake.learning.subjects import NOMINAL, Subject, between_patients
from tests.commands import run_command
from tests.learning_tasks import random_policy, short_task


class TestRollouts(unittest.TestCase):
    def test_a_policy_does_in_the_benchmark_what_it_does_in_its_env(self):
        task = short_task(8, reward=improved(), subjects=between_patients())
        policy, subject = random_policy(task), Subject({"preload": 1.2})
        log = run_episode(
            RlpicEnv(task), policy.act, options={"subject": subject}
        )
        rollout = Benchmark(task).run(
            Controller("rlpic", policy=policy), subject
        )
        at = slice(SAMPLES - 1, None, SAMPLES)
        for name in ("position", "rate", "force", "desired"):
            np.testing.assert_array_equal(
                getattr(rollout.signals, name)[at], getattr(log.signals, name)
            )
        np.testing.assert_array_equal(rollout.stiffness[at], log.stiffness)
        self.assertAlmostEqual(rollout.total, log.total, places=9)

    def test_controllers_do_what_they_do_in_their_diagram(self):
        task = short_task(6)
        benchmark, push = Benchmark(task), LoadPush()
        for tag in ("pic", "npic", "mraic", "vpic"):
            with self.subTest(tag=tag):
                (there,) = compare_controllers(
                    benchmark.scenario, _cut(push, 0.31), (tag,)
                )
                here = benchmark.run(Controller(tag, tag), NOMINAL)
                period = benchmark.scenario.sensors.log_period
                every = round(period / (task.sample_time / SAMPLES))
                mine = here.signals.position[every - 1 :: every, 1]
                X = there.log.X[1 : len(mine) + 1, 0, 1]
                np.testing.assert_allclose(mine[: len(X)], X, atol=2e-7)

    def test_a_stiffer_constant_gives_way_as_its_spring_says(self):
        benchmark = Benchmark(short_task(20, displacement=np.array(
            [0, -0.002, 0, 0, 0, 0.0]), motion_time=0.5))  # fmt: skip
        ends = []
        for K in (3000.0, 30000.0):
            out = benchmark.run(Controller("", "pic", stiffness=K), NOMINAL)
            virtual = out.signals.force[-1, 1] / K
            ends.append((out.signals.desired - out.signals.position)[-1, 1])
            self.assertAlmostEqual(abs(ends[-1]), virtual, delta=0.3 * virtual)
        self.assertGreater(abs(ends[0]), 5.0 * abs(ends[1]))

    def test_a_push_beyond_a_limit_goes_on_and_is_counted(self):
        task = short_task(6)
        task.limits.speed[1] = 1e-9
        rollout = Benchmark(task).run(Controller("pic"), NOMINAL)
        self.assertEqual(len(rollout.time), 6 * SAMPLES)
        self.assertIn("speed", rollout.cause)
        score = Benchmark(task).score(rollout)
        self.assertTrue(score.broke and score.violates)
        self.assertFalse(score.over_force)


class TestFailures(unittest.TestCase):
    def test_a_push_that_breaks_down_is_the_worst_there_can_be(self):
        benchmark, whole = (
            Benchmark(short_task(6)),
            rollouts.CompiledLoop.advance,
        )
        for good in (None, 0, 7):
            with self.subTest(samples=good):
                calls = []

                def advance(loop, asked, good=good, calls=calls):
                    calls.append(asked)
                    if len(calls) > good:
                        raise BraceError("out of bounds")
                    whole(loop, asked)

                def start(loop, episode, asked):
                    raise BraceError("out of reach")

                broken = (
                    mock.patch.object(rollouts.CompiledLoop, "start", start)
                    if good is None
                    else mock.patch.object(
                        rollouts.CompiledLoop, "advance", advance
                    )
                )
                with broken:
                    push = benchmark.run(Controller("pic"), NOMINAL)
                self.assertRegex(push.cause, "failed: out of (bounds|reach)")
                self.assertEqual(len(push.time), good or 0)
                self.assertEqual(push.stiffness.shape[1:], (1,))
                self.assertEqual(push.total, -np.inf)
                score = benchmark.score(push)
                self.assertTrue(score.broke and score.violates)
                self.assertEqual(
                    {score.y_rms, score.peak_force, -score.total}, {np.inf}
                )

    def test_a_constant_that_breaks_down_wins_no_search(self):
        class Cliff:
            law = Benchmark(short_task()).law

            def run(self, contestant, subject):
                K = contestant.stiffness
                total = K if K < 5000.0 else -np.inf
                return type("R", (), {"total": total})

        with open_workers(1) as workers:
            found = search_constant(Cliff(), (NOMINAL,), workers)
        self.assertLess(found.best, 5000.0)
        self.assertGreater(found.best, 3000.0)

    def test_intervals_of_pushes_that_failed_are_no_numbers_made_up(self):
        inf = np.inf
        self.assertEqual(student_interval([1.0, inf]).value, inf)
        self.assertTrue(np.isnan(student_interval([1.0, inf]).upper))
        few = median_interval([1.0, 2.0, 3.0, 4.0, inf])
        self.assertEqual(few.value, 3.0)
        self.assertEqual((few.lower, few.upper), (1.0, inf))


class TestWords(unittest.TestCase):
    def say(self, error, violates=False):
        """On a policy of an error, mm, beside constants of 1, 2 and 3 kN/m."""

        def score(y, over=False):
            return SimpleNamespace(y_rms=1e-3 * y, violates=over)

        scores = {"constant": [score(0.2)], "rlpic": [score(error, violates)]}
        return _on_nominal_need(
            SimpleNamespace(
                on_nominal=scores.get,
                nominal_search=SimpleNamespace(best=1000.0, at_upper=False),
                nominal_sweep={
                    2000.0: score(0.1),
                    3000.0: score(0.05, over=True),
                    4000.0: score(np.inf, over=True),
                },
            ),
            "rlpic",
        )

    def test_the_rival_is_the_constant_of_the_least_error(self):
        # Less than the constant of the best return is not less than any.
        self.assertIn("search over one number does better", self.say(0.12))
        self.assertIn("search over one number does as well", self.say(0.1))
        said = self.say(0.08)
        self.assertIn("2000 N/m with 0.1000 mm", said)
        self.assertIn("of use: 20 % less than that", said)

    def test_a_policy_that_violates_is_held_to_constants_that_do(self):
        said = self.say(0.08, violates=True)
        self.assertIn("3000 N/m with 0.0500 mm", said)
        self.assertIn("not needed", said)


def _cut(run, end):
    keep = run.time_s <= end
    return replace(run, channels={k: v[keep] for k, v in run.channels.items()})


PIC = Controller("pic", "pic")


class TestPackagedPolicy(unittest.TestCase):
    def test_it_tracks_within_the_papers_table_1_and_below_4_N(self):
        policy = LoadPolicy(policy_path())
        benchmark = Benchmark(policy.task)
        push = benchmark.run(Controller("rlpic", policy=policy), NOMINAL)
        score = benchmark.score(push)
        for name in ("y_rms", "vy_rms", "x_rms", "z_rms"):
            self.assertLessEqual(
                getattr(score, name), getattr(TABLE_1_RLPIC, name)
            )
        self.assertLess(score.start_rate, 0.6e-3)
        self.assertFalse(score.violates)

    def test_it_gives_way_to_a_stiff_wearer_whom_pic_presses_too_hard(self):
        policy = LoadPolicy(policy_path())
        benchmark = Benchmark(policy.task)
        stiff = replace(
            NOMINAL, factors={**NOMINAL.factors, "posture_stiffness": 1.45}
        )
        scores = [
            benchmark.run_and_score(who, stiff)
            for who in (Controller("rlpic", policy=policy), PIC)
        ]
        self.assertEqual([s.violates for s in scores], [False, True])
        self.assertLess(scores[0].peak_force, 4.0)


class TestSearch(unittest.TestCase):
    def test_it_finds_the_top_of_a_curve_between_its_grid(self):
        class Curve:
            law = Benchmark(short_task()).law

            def run(self, contestant, subject):
                off = np.log(contestant.stiffness / subject)
                return type("R", (), {"total": -float(off**2)})

        with open_workers(1) as workers:
            found = search_constant(Curve(), (2900.0,), workers)
            self.assertAlmostEqual(np.log(found.best / 2900.0), 0, delta=0.04)
            self.assertFalse(found.at_upper)
            end = search_constant(Curve(), (1e9,), workers)
        self.assertTrue(end.at_upper)
        self.assertEqual(end.best, Curve.law.upper)


class TestIntervals(unittest.TestCase):
    def test_students_interval_covers_as_often_as_it_says(self):
        rng = np.random.default_rng(2)
        hits = 0
        for _ in range(2000):
            found = student_interval(rng.normal(3.0, 2.0, 3))
            hits += found.lower <= 3.0 <= found.upper
        self.assertAlmostEqual(hits / 2000, 0.95, delta=0.015)
        self.assertTrue(np.isnan(student_interval([1.0]).lower))

    def test_wilsons_and_the_bootstraps_intervals_cover(self):
        rng, share, median = np.random.default_rng(3), 0, 0
        for i in range(200):
            found = share_interval(rng.random(50) < 0.2)
            share += found.lower <= 0.2 <= found.upper
            found = median_interval(rng.normal(size=50), seed=i)
            median += found.lower <= 0.0 <= found.upper
        self.assertGreater(share / 200, 0.91)
        self.assertGreater(median / 200, 0.89)


class TestEvaluate(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        task = short_task(5, reward=improved(), subjects=between_patients())
        cls.files = []
        for seed in range(3):
            file = cls.folder / f"seed{seed}.npz"
            SavePolicy(random_policy(task, seed), file)
            cls.files.append(str(file))
        cls.out = cls.folder / "out"
        cls.status, cls.printed, _ = run_command(
            "evaluate", *cls.files, "--out", cls.out, "--subjects", 4,
            "--searched", 2, "--seeds", 2, "--jobs", 1,
        )  # fmt: skip

    def rows(self, name):
        with (self.out / name).open() as file:
            return list(csv.DictReader(file))

    def test_it_writes_table_figures_and_a_page_that_needs_nothing_else(self):
        self.assertEqual(self.status, 0)
        names = {p.name for p in self.out.iterdir()}
        figures = {f"figure_{i}.png" for i in range(8, 14)}
        self.assertLessEqual(figures | {"unseen.png"}, names)
        page = (self.out / "evaluation.html").read_text()
        self.assertEqual(page.count("data:image/png"), 7)
        self.assertNotRegex(page, r'(src|href)="(?!data:)')
        self.assertIn("learning was", self.printed)

    def test_table_1_has_the_papers_rows_and_one_for_each_seed(self):
        rows = self.rows("table_1.csv")
        names = [r["controller"] for r in rows]
        expected = ["pic", "npic", "mraic", "vpic", "constant"]
        papers = ["pic, the paper", "rlpic, the paper"]
        self.assertEqual(names, [*expected, "rlpic", "rlpic", *papers])
        self.assertEqual(float(rows[-1]["y_rmse_mm"]), 0.15245)
        self.assertEqual(rows[-1]["peak_force_N"], "")

    def test_all_meet_the_same_subjects_and_the_summary_is_of_the_pushes(self):
        pushes = self.rows("pushes.csv")
        self.assertEqual(len(pushes), 7 * 4)
        factors = {
            (r["subject"], r["contact_stiffness"], r["preload"]) for r in pushes
        }
        self.assertEqual(len(factors), 4)
        summary = {r["controller"]: r for r in self.rows("unseen.csv")}
        errors = np.array(
            [[float(r["y_rms"]) for r in pushes if r["controller"] == "rlpic"
              and r["seed"] == str(s)] for s in range(2)]
        )  # fmt: skip
        medians = 1e3 * np.median(errors, axis=1)
        row = summary["rlpic"]
        self.assertAlmostEqual(float(row["median"]), medians.mean(), delta=1e-5)
        half = 12.706 * medians.std(ddof=1) / 2**0.5
        self.assertAlmostEqual(
            float(row["median_seeds_upper95"]),
            medians.mean() + half,
            delta=1e-4,
        )

    def test_a_push_is_the_same_however_many_there_are(self):
        ranges = between_patients()
        few = evaluate.draw_subjects(ranges, 2, 7)
        many = evaluate.draw_subjects(ranges, 5, 7)
        self.assertEqual(few, many[:2])
        others = evaluate.draw_subjects(ranges, 2, 7, stream=1)
        self.assertNotEqual(few, others)

    def test_policies_of_one_task_are_seeds_others_are_rivals(self):
        task = short_task(5)
        same = [random_policy(task, s) for s in range(2)]
        other = random_policy(short_task(5, subjects=between_patients()), 2)
        found = evaluate.gather_policies([same[0], other, same[1]])
        self.assertEqual([c.seed for c in found], [0, 1, 0])
        self.assertEqual(len({c.name for c in found}), 2)
        drawn = evaluate.make_task(found).subjects
        np.testing.assert_array_equal(drawn.preload, [0.7, 1.5])

    def test_policies_of_other_motions_are_refused(self):
        policies = [
            random_policy(short_task(5)),
            random_policy(short_task(5, motion_time=6.0)),
        ]
        with self.assertRaisesRegex(PolicyError, "policy 2: of another"):
            evaluate.gather_policies(policies)

    def test_a_file_that_is_no_policy_is_named_in_one_line(self):
        status, _, errors = run_command(
            "evaluate", "nothing.npz", "--out", self.folder / "o"
        )
        self.assertEqual(status, 2)
        self.assertRegex(errors, r"^brace-drake: nothing.npz: ")


if __name__ == "__main__":
    unittest.main()
