"""Policies of a bench's twin on the simulator of the bench."""

import csv
import io
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
from pydrake.common.yaml import yaml_dump_typed

from brace_drake.core.errors import BraceError
from brace_drake.core.output import WriteText
from brace_drake.core.parallel import open_workers
from brace_drake.core.resources import scenario_path
from brace_drake.devices.bench.rollout import Motion
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.effects.registry import find_effect
from brace_drake.experiments.rollouts import Benchmark, Controller
from brace_drake.experiments.scores import FAILED, Push
from brace_drake.experiments.tables import format_csv
from brace_drake.experiments.transfer import experiment
from brace_drake.experiments.transfer.bench_push import cubic_push, push_bench
from brace_drake.experiments.transfer.experiment import (
    MakeBenchTask,
    TransferOptions,
)
from brace_drake.experiments.transfer.table import (
    conclude,
    format_markdown,
    spreads_of,
)
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.policy import SavePolicy
from brace_drake.learning.subjects import NOMINAL, Subject
from brace_drake.scenario.brace import EffectUse
from brace_drake.scenario.load import LoadScenario, SaveScenario
from brace_drake.withheld.simulator import Decisions, Flaws, run_bench
from brace_drake.withheld.simulator import Subject as Wearer
from tests.learning_tasks import random_policy

_TIME = 0.4


class TestBenchTask(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.file = folder / "brace.scenario.yaml"
        self.bench = LoadScenario(scenario_path("bench.scenario.yaml"))
        # Fine enough to tell small differences.
        self.bench.sensors.force_resolution = 1e-9
        self.bench.sensors.leg_length_resolution = 1e-12

    def task(self, bench):
        task = MakeBenchTask(bench, self.file)
        return replace(
            task, max_steps=8, motion_time=_TIME, readings="exact",
            displacement=np.array([0, -4e-4, 0, 0, 0, 0.0]),
        )  # fmt: skip

    def replayed(self, bench):
        twin = BenchTwin(bench)
        wanted = cubic_push(-4e-4, _TIME)
        values = np.array([p.nominal for p in twin.subject])
        return twin.simulate(Motion(wanted, True, 5), values)

    def compare(self, bench, subject):
        rollout = Benchmark(self.task(bench)).run(Controller("pic"), subject)
        log = self.replayed(bench)
        np.testing.assert_allclose(
            -rollout.signals.force[:75, 1], log[1:76, 13], atol=1e-5
        )
        return rollout

    def test_the_task_is_the_bench_that_diagnoses_replay(self):
        self.compare(self.bench, NOMINAL)

    def test_effects_of_a_repaired_bench_are_those_of_every_subject(self):
        card = find_effect("relaxation")
        values = card.starts()[0]
        named = dict(zip(card.parameter_names, map(float, values), strict=True))
        bench = replace(self.bench, effects=[EffectUse("relaxation", named)])
        task = self.task(bench)
        env = RlpicEnv(task)
        env.reset(seed=5)
        drawn = env._episode.uses
        self.assertEqual([c.name for c, _ in drawn], ["relaxation"])
        np.testing.assert_array_equal(drawn[0][1], values)
        with_it = self.compare(bench, Subject({}, (values,)))
        without = Benchmark(self.task(self.bench)).run(
            Controller("pic"), NOMINAL
        )
        self.assertGreater(
            np.abs(with_it.signals.force - without.signals.force).max(), 0.01
        )


class TestSimulator(unittest.TestCase):
    def test_a_constant_decision_changes_nothing_of_a_run(self):
        wanted = cubic_push(-4e-4, 0.2)
        logs = [
            run_bench(
                wanted, True, Wearer(), Flaws(), np.random.default_rng(1),
                decisions=decisions,
            )
            for decisions in (None, Decisions(50, lambda tick, run: 6000.0))
        ]  # fmt: skip
        np.testing.assert_array_equal(*logs)

    def test_decisions_see_the_tick_before_and_act_from_the_next(self):
        wanted, told = cubic_push(-4e-4, 0.2), []

        def decide(tick, run):
            told.append((tick, run.sent[tick].any(), run.sent[tick + 1].any()))
            return 6000.0

        run_bench(
            wanted, True, Wearer(), Flaws(), np.random.default_rng(1),
            decisions=Decisions(50, decide),
        )  # fmt: skip
        ticks, seen, ahead = zip(*told, strict=True)
        self.assertEqual(ticks, (0, 50, 100, 150))
        self.assertTrue(all(seen) and not any(ahead))

    def test_a_nominal_policy_does_there_what_it_does_in_its_twin(self):
        with tempfile.TemporaryDirectory() as folder:
            bench = LoadScenario(scenario_path("bench.scenario.yaml"))
            task = MakeBenchTask(bench, Path(folder) / "b.scenario.yaml")
            task = replace(
                task, max_steps=8, motion_time=_TIME, readings="exact",
                displacement=np.array([0, -4e-4, 0, 0, 0, 0.0]),
            )  # fmt: skip
            policy = random_policy(task)
            here = Benchmark(task).run(
                Controller("rlpic", policy=policy), NOMINAL
            )
        there = push_bench(Wearer(), Flaws(), policy, -4e-4, _TIME, noise=False)
        error = here.signals.desired - here.signals.position
        # Rows of the simulator are decisions, before what follows on them.
        mine = here.stiffness[9::10, 0]
        self.assertGreater(np.ptp(mine), 500.0)
        np.testing.assert_allclose(there.stiffness[:7], mine[:7], rtol=0.05)
        np.testing.assert_allclose(
            there.error[1:8, 0], error[9:79:10, 1], atol=5e-6
        )


class TestPayoff(unittest.TestCase):
    def test_what_a_folder_has_is_not_made_again_and_all_meet_there(self):
        trained = []

        def train(folder, task):
            file = folder / "best.npz"
            if not file.exists():
                folder.mkdir(parents=True)
                trained.append(task)
                SavePolicy(random_policy(task), file)
            return file

        with (
            tempfile.TemporaryDirectory() as folder,
            open_workers(1) as workers,
        ):
            out = Path(folder)
            bench = LoadScenario(scenario_path("bench.scenario.yaml"))
            use = EffectUse("command_delay", {"delay_s": 0.008})
            (out / "command_delay").mkdir()
            WriteText(
                out / experiment.OPTIONS, yaml_dump_typed(TransferOptions())
            )
            SaveScenario(
                replace(bench, effects=[use]),
                out / "command_delay" / experiment.FILE,
            )
            short = mock.patch.object(experiment, "push_bench", _push_shortly)
            self.enterContext(short)
            first, again = (
                experiment.run_transfer(
                    out, train, workers, TransferOptions(), causes, pushes=1
                )
                for causes in (["command_delay"], [" command_delay", ""])
            )
            for change, text in (
                ({"severity": "small"}, "severity: begun with large, asked"),
                ({"force_limit": 9.0}, "force_limit: begun with 20.0"),
                ({"seed": 4}, "seed: begun with 0, asked for is 4"),
            ):
                with self.assertRaisesRegex(BraceError, text):
                    other = TransferOptions(**change)
                    experiment.run_transfer(
                        out, train, workers, other, ["command_delay"]
                    )
        self.assertEqual(len(trained), 2)
        self.assertEqual([len(t.subjects.effects) for t in trained], [0, 1])
        self.assertEqual(
            [o.controller for o in first], ["pic", "nominal", "repaired"]
        )
        self.assertEqual(first, again)
        # The same network on the same machine.
        self.assertEqual(first[1].score, first[2].score)
        self.assertNotEqual(first[0].score, first[1].score)

    def test_a_run_that_was_stopped_in_its_diagnosis_diagnoses_its_file(self):
        case, seen = experiment.make_case("force_bias", "large", 0), []

        def stop(campaign, *_):
            seen.append(campaign)
            raise KeyboardInterrupt

        self.enterContext(mock.patch.object(experiment, "diagnose", stop))
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "force_bias"
            out.mkdir()
            for _ in range(2):
                with self.assertRaises(KeyboardInterrupt):
                    experiment.repair_twin(case, out, 0, 1)
            first, again = seen
            # The provenance of a diagnosis is of files that are there.
            self.assertTrue((first.path / "campaign.yaml").exists())
            self.assertEqual(first.path, again.path)
            for one, other in zip(first.runs, again.runs, strict=True):
                np.testing.assert_array_equal(
                    one.channels["leg1_length_m"],
                    other.channels["leg1_length_m"],
                )

    def test_the_table_says_how_much_better_it_is(self):
        rows = [
            _outcome(name, i, y + noise)
            for name, y in (("nominal", 2e-4), ("repaired", 1e-4))
            for i, noise in enumerate((-1e-5, 0.0, 1e-5))
        ]
        # Noise that both share takes nothing from the difference.
        self.assertIn("50.0 % less error", conclude(rows)[0])
        self.assertIn("Separable: 95 % interval", conclude(rows)[0])
        self.assertIn("less 50.0 to 50.0 %", conclude(rows)[0])
        table = list(csv.DictReader(io.StringIO(format_csv(spreads_of(rows)))))
        self.assertEqual(len(table), 2)
        self.assertEqual(float(table[1]["y_rmse_mm"]), 0.1)
        # Student's 97.5 % point of two degrees of freedom is 4.3027.
        half = 4.3027 * 0.01 / 3**0.5
        upper = float(table[1]["y_rmse_mm_upper95"])
        self.assertAlmostEqual(upper, 0.1 + half, delta=1e-6)
        self.assertIn(
            "| relaxation | repaired | 0.1 +- 0.025 |", format_markdown(rows)
        )

    def test_a_difference_within_the_noise_is_not_separable(self):
        rows = [
            *(_outcome("nominal", i, y) for i, y in enumerate((2e-4, 1e-4))),
            *(_outcome("repaired", i, y) for i, y in enumerate((1e-4, 1.8e-4))),
        ]
        self.assertIn("Not separable: 95 % interval", conclude(rows)[0])
        one = [_outcome("nominal", 0, 2e-4), _outcome("repaired", 0, 1e-4)]
        self.assertIn("One push has no interval", conclude(one)[0])
        self.assertIn("| relaxation | nominal | 0.2 |", format_markdown(one))

    def test_chance_of_the_pushes_is_that_of_the_seed(self):
        def push(subject, flaws, policy, way, duration, seed):
            error = np.random.default_rng(seed).normal(size=(50, 3))
            still = np.zeros(50)
            return Push(still, error, still, still, still)

        def errors(seed):
            with (
                open_workers(1) as workers,
                mock.patch.object(experiment, "push_bench", push),
            ):
                case = experiment.make_case("relaxation", "large", 0)
                found = experiment.compare_on_machine(
                    case, "relaxation",
                    {"pic": None, "nominal": None},
                    TransferOptions(seed=seed), 3, workers,
                )  # fmt: skip
            rows = [
                [o.score.y_rms for o in found if o.controller == who]
                for who in ("pic", "nominal")
            ]
            self.assertEqual(*rows)
            return rows[0]

        self.assertEqual(errors(0), errors(0))
        self.assertEqual(len({*errors(0), *errors(1)}), 6)

    def test_an_unknown_cause_is_named(self):
        with self.assertRaisesRegex(BraceError, "'rust'; allowed: coulomb"):
            experiment.make_case("rust", "large", 0)

    def test_nothing_is_trained_or_written_for_a_wrong_word(self):
        def train(folder, task):
            self.fail("trained")

        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "new"
            for causes, text in (
                (["relaxation", "rust"], "'rust'; allowed"),
                ([""], "no cause"),
            ):
                with self.assertRaisesRegex(BraceError, text):
                    experiment.run_transfer(
                        out, train, None, TransferOptions(), causes
                    )
            self.assertFalse(out.exists())
            (Path(folder) / "notes.txt").touch()
            with self.assertRaisesRegex(BraceError, "and no payoff.yaml"):
                experiment.run_transfer(
                    Path(folder), train, None, TransferOptions()
                )


def _push_shortly(subject, flaws, policy, way, duration, seed):
    """A push of the simulator itself, of its first part alone."""
    return push_bench(subject, flaws, policy, way * _TIME / 12.0, _TIME, seed)


def _outcome(controller, push, error):
    score = replace(FAILED, y_rms=error, peak_force=9.0, stiffness=1e4)
    return experiment.Outcome("relaxation", controller, push, score, 0.5)


if __name__ == "__main__":
    unittest.main()
