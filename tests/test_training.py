"""PPO with the paper's numbers, stopped, killed and resumed."""

import io
import json
import multiprocessing
import tempfile
import time
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.core.errors import PolicyError, ScenarioError
from brace_drake.learning.policy import LoadPolicy
from brace_drake.learning.subjects import (
    NOMINAL,
    EffectRange,
    SubjectRanges,
    between_patients,
)
from tests.commands import run_command
from tests.learning_tasks import short_task

try:
    import torch
    from stable_baselines3 import PPO

    from brace_drake.learning.training.actor_critic import ThresholdAdam
    from brace_drake.learning.training.learner import Learner, _subjects_of
    from brace_drake.learning.training.numbers import TrainingNumbers
    from brace_drake.learning.training.run_folder import LoadCheckpoint
    from brace_drake.learning.training.train import (
        ResumeTraining,
        StartTraining,
        TrainPolicy,
    )
except ImportError as error:
    raise unittest.SkipTest("stable-baselines3 is not installed") from error


def tiny_task():
    # Episodes end in the middle of a horizon.
    return short_task(5, subjects=between_patients(), readings="noisy")


def tiny_numbers(**changes):
    sizes = {"horizon": 8, "batch_size": 4, "epochs": 2, "hidden": 8}
    rest = {"episodes": 8, "evaluate_every": 2, "seed": 3}
    return TrainingNumbers(**{**sizes, **rest, **changes})


def train_slowly(folder, updated):
    """What a process of its own runs, to be killed."""

    def slow(done, total, mean, best):
        updated.release()
        time.sleep(0.2)

    StartTraining(folder, tiny_task(), tiny_numbers(), slow)


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))


class TestResume(Folder):
    def test_a_killed_run_ends_with_the_weights_of_one_that_was_not(self):
        whole, killed = self.folder / "whole", self.folder / "killed"
        result = StartTraining(whole, tiny_task(), tiny_numbers())
        self.assertEqual(result["steps"], 40)
        # A copy of this process has its imports already.
        context = multiprocessing.get_context("fork")
        updated = context.Semaphore(0)
        process = context.Process(target=train_slowly, args=(killed, updated))
        process.start()
        for _ in range(2):
            self.assertTrue(updated.acquire(timeout=60))
        time.sleep(0.05)
        process.kill()
        process.join()
        state = torch.load(killed / "checkpoint.pt", weights_only=False)
        self.assertLess(state["learner"]["counts"]["num_timesteps"], 40)
        self.assertEqual(ResumeTraining(killed), result)
        for name in ("policy.npz", "best.npz"):
            a, b = LoadPolicy(whole / name), LoadPolicy(killed / name)
            for x, y in zip(
                (*a.weights, *a.biases, a.mean, a.gain),
                (*b.weights, *b.biases, b.mean, b.gain),
                strict=True,
            ):
                np.testing.assert_array_equal(x, y)
        self.assertEqual(a.task.scenario, b.task.scenario)
        curves = [(f / "curve.csv").read_text() for f in (whole, killed)]
        self.assertEqual(*curves)

    def test_every_update_goes_on_bit_for_bit(self):
        for envs in (1, 4):
            with self.subTest(envs=envs):
                self.check_updates(tiny_numbers(envs=envs))

    def check_updates(self, numbers):
        straight = Learner(tiny_task(), numbers)
        for _ in range(4):
            straight.advance()
        part = Learner(tiny_task(), numbers)
        for _ in range(4):
            part.advance()
            memory = io.BytesIO()
            torch.save(part.state(), memory)
            memory.seek(0)
            part.close()
            # The state of the process is another one by now.
            torch.rand(3)
            np.random.rand(3)  # noqa: NPY002
            part = Learner(tiny_task(), replace(numbers, seed=99))
            part.set_state(torch.load(memory, weights_only=False))
        a, b = straight.model.policy, part.model.policy
        for x, y in zip(a.parameters(), b.parameters(), strict=True):
            self.assertTrue(torch.equal(x, y))

    def test_the_deviation_has_an_end_and_no_pay_moves_it_further(self):
        numbers = tiny_numbers(
            largest_deviation=0.6, entropy_weight=50.0, learning_rate=0.05
        )
        learner = Learner(tiny_task(), numbers)
        self.addCleanup(learner.close)
        for _ in range(4):
            learner.advance()
        observation = torch.randn((20, 7)) * 3.0
        spread = learner.model.policy.get_distribution(observation)
        deviation = spread.distribution.stddev
        self.assertLessEqual(float(deviation.max()), 0.6 + 1e-6)
        self.assertGreater(float(deviation.median()), 0.59)

    def test_evaluations_see_the_same_subjects_of_their_ranges(self):
        wide = _subjects_of(tiny_task(), 4)
        self.assertEqual(len(wide), 4)
        self.assertIs(wide[0], NOMINAL)
        self.assertEqual(wide, _subjects_of(tiny_task(), 4))
        self.assertEqual(_subjects_of(short_task(5), 4), [NOMINAL])
        use = EffectRange("coulomb_friction", parameters={
            "coulomb_N": np.array([0.1, 0.3])})  # fmt: skip
        rough = short_task(5, subjects=SubjectRanges(effects=[use]))
        self.assertEqual([len(_subjects_of(rough, n)) for n in (1, 4)], [1, 4])
        use = EffectRange("coulomb_friction", parameters={
            "coulomb_N": np.array([0.3, 0.3])})  # fmt: skip
        fixed = short_task(5, subjects=SubjectRanges(effects=[use]))
        (one,) = _subjects_of(fixed, 4)
        np.testing.assert_array_equal(one.effects[0], [0.3])

    def test_patience_ends_a_run_and_the_best_is_kept(self):
        numbers = tiny_numbers(
            patience=1, evaluate_every=1, learning_rate=1e-12, episodes=40
        )
        result = StartTraining(self.folder, tiny_task(), numbers)
        self.assertTrue(result["stopped"])
        self.assertLess(result["updates"], 25)
        self.assertTrue((self.folder / "best.npz").exists())
        # Over is over: begun again it stays where it was.
        before = (self.folder / "policy.npz").read_bytes()
        self.assertEqual(ResumeTraining(self.folder), result)
        self.assertEqual((self.folder / "policy.npz").read_bytes(), before)

    def test_a_run_of_other_options_is_not_taken_for_this_one(self):
        task, numbers = tiny_task(), tiny_numbers(episodes=1)
        TrainPolicy(self.folder, task, numbers)
        moved = self.folder / "elsewhere.scenario.yaml"
        scenario = (self.folder / "used.scenario.yaml").read_text()
        moved.write_text(scenario)
        best = (self.folder / "best.npz").read_bytes()
        for same in (task, replace(task, scenario=str(moved))):
            TrainPolicy(self.folder, same, numbers)
        self.assertEqual((self.folder / "best.npz").read_bytes(), best)
        moved.write_text(scenario.replace("mass: 40.0", "mass: 41.0"))
        self.assertNotEqual(moved.read_text(), scenario)
        for changed, other, text in (
            (task, replace(numbers, episodes=2), "episodes: begun with 1,"),
            (task, replace(numbers, seed=9), "seed: begun with 3,"),
            (replace(task, motion_time=9.0), numbers, "motion_time: begun"),
            (replace(task, scenario=str(moved)), numbers, "torso: begun"),
        ):
            with self.assertRaisesRegex(PolicyError, text):
                TrainPolicy(self.folder, changed, other)

    def test_a_checkpoint_that_could_run_code_is_refused(self):
        class Trap:
            def __reduce__(self):
                return print, ("the trap has sprung",)

        for what in ({"learner": Trap()}, {"learner": {"random": [Trap()]}}):
            torch.save(what, self.folder / "checkpoint.pt")
            with self.assertRaisesRegex(PolicyError, "no checkpoint"):
                LoadCheckpoint(self.folder)

    def test_a_checkpoint_of_an_older_version_is_refused_in_one_line(self):
        StartTraining(self.folder, tiny_task(), tiny_numbers(episodes=1))
        state = LoadCheckpoint(self.folder)
        del state["format"]
        torch.save(state, self.folder / "checkpoint.pt")
        with self.assertRaisesRegex(PolicyError, "format 1; allowed: 2") as e:
            ResumeTraining(self.folder)
        self.assertNotIn("\n", str(e.exception))

    def test_folders_are_checked(self):
        with self.assertRaisesRegex(PolicyError, "no training run"):
            ResumeTraining(self.folder)
        StartTraining(self.folder, tiny_task(), tiny_numbers(episodes=1))
        with self.assertRaisesRegex(PolicyError, "resume"):
            StartTraining(self.folder, tiny_task(), tiny_numbers())
        path = self.folder / "manifest.json"
        manifest = json.loads(path.read_text())
        manifest["versions"]["torch"] = "0.1"
        path.write_text(json.dumps(manifest))
        with self.assertRaisesRegex(PolicyError, r"torch 0\.1"):
            ResumeTraining(self.folder)
        for damage in ("{", "[]", "{}", '{"versions": 3}', "\x00"):
            path.write_text(damage)
            with self.assertRaisesRegex(PolicyError, r"manifest\.json: "):
                ResumeTraining(self.folder)


class TestNetwork(unittest.TestCase):
    def collected(self):
        """A learner with its first horizon; its seed is that of the process."""
        learner = Learner(tiny_task(), tiny_numbers(envs=2))
        m = learner.model
        m.collect_rollouts(
            m.env, learner._callback, m.rollout_buffer, m.n_steps
        )
        return learner

    def test_an_update_is_that_of_stable_baselines(self):
        ours = self.collected()
        ours.model.train()
        theirs = self.collected()
        # One optimiser that steps both, as stable-baselines3 has it.
        policy = theirs.model.policy
        actor, critic = policy.optimizers
        policy.optimizer = mock.Mock(
            param_groups=[*actor.param_groups, *critic.param_groups],
            step=lambda: [actor.step(), critic.step()],
            zero_grad=lambda: [actor.zero_grad(), critic.zero_grad()],
        )
        PPO.train(theirs.model)
        pairs = zip(
            ours.model.policy.parameters(), policy.parameters(), strict=True
        )
        for a, b in pairs:
            torch.testing.assert_close(a, b, rtol=0, atol=1e-6)
        for name in ("value_loss", "entropy_loss", "approx_kl"):
            a, b = (
                learner.model.logger.name_to_value[f"train/{name}"]
                for learner in (ours, theirs)
            )
            self.assertAlmostEqual(a, float(b), places=5)

    def test_numpy_says_what_torch_says(self):
        learner = Learner(tiny_task(), tiny_numbers(hidden=256))
        learner.advance()
        policy, model = learner.policy(), learner.model
        rows = np.random.default_rng(0).normal(size=(40, 7)) * 5e-3
        for row in rows:
            scaled = learner._scaled.normalize_obs(row[None])
            expected = model.policy.predict(scaled, deterministic=True)[0][0]
            np.testing.assert_allclose(
                policy.act(row), expected, rtol=0, atol=1e-6
            )

    def test_hyper_parameters_of_the_paper_arrive(self):
        learner = Learner(short_task(), TrainingNumbers())
        model: PPO = learner.model
        self.assertEqual(
            (model.n_steps, model.batch_size, model.n_epochs), (512, 64, 10)
        )
        self.assertEqual(
            (model.gamma, model.gae_lambda, model.ent_coef), (0.99, 0.95, 0.01)
        )
        self.assertEqual(model.clip_range(1.0), 0.2)
        groups = [o.param_groups[0] for o in model.policy.optimizers]
        self.assertEqual([g["weight_decay"] for g in groups], [1e-5, 2e-4])
        self.assertEqual(groups[0]["betas"], (0.9, 0.999))
        self.assertEqual((groups[0]["eps"], groups[0]["lr"]), (1e-8, 3e-4))
        sizes = [[p.shape[0] for p in g["params"]] for g in groups]
        self.assertEqual(sizes[1], [256, 256, 256, 256, 1, 1])
        self.assertEqual(sizes[0], [256, 256, 256, 256, 1, 1, 1, 1])
        # Two hidden layers, the mean and the deviation side by side.
        self.assertEqual(len(list(model.policy.parameters())), 14)

    def test_each_gradient_is_cut_by_itself(self):
        big, small = (torch.nn.Parameter(torch.zeros(2)) for _ in range(2))
        optimizer = ThresholdAdam([{"params": [big, small]}], threshold=1.0)
        big.grad, small.grad = (
            torch.tensor([3.0, 4.0]),
            torch.tensor([0.3, 0.4]),
        )
        optimizer.step()
        torch.testing.assert_close(big.grad, torch.tensor([0.6, 0.8]))
        torch.testing.assert_close(small.grad, torch.tensor([0.3, 0.4]))

    def test_numbers_are_checked(self):
        for change, text in (
            ({"gamma": 1.5}, "gamma"),
            ({"horizon": 9, "envs": 2}, "horizon"),
            ({"hidden": 0}, "hidden"),
        ):
            numbers = tiny_numbers(**change)
            with self.assertRaisesRegex(ScenarioError, text):
                StartTraining(Path("nowhere"), tiny_task(), numbers)
        self.assertFalse(Path("nowhere").exists())


class TestCommands(Folder):
    def test_train_then_predict(self):
        (self.folder / "task.yaml").write_text("max_steps: 4\n")
        (self.folder / "training.yaml").write_text(
            "horizon: 8\nbatch_size: 4\nepochs: 1\nhidden: 8\n"
        )
        run = self.folder / "run"
        trained, _, errors = run_command(
            "train", "--out", run, "--episodes", 2,
            "--task", self.folder / "task.yaml",
            "--training", self.folder / "training.yaml",
            "--reward", "improved",
        )  # fmt: skip
        self.assertEqual(trained, 0, errors)
        status, said, errors = run_command(
            "predict", run / "best.npz", "--out", self.folder / "out",
            "--displacement-mm", -5, "--subject", "torso_mass=1.2",
        )  # fmt: skip
        self.assertEqual(status, 0, errors)
        self.assertIn("ring2 y: K_d", said)
        made = json.loads((self.folder / "out/prediction.json").read_text())
        self.assertGreater(made["ring2 y"]["stiffness_N_m"], 500.0)
        rows = (self.folder / "out/course.csv").read_text().splitlines()
        self.assertEqual(len(rows), 5)
        self.assertEqual(
            {p.name for p in run.iterdir()},
            {
                "best.npz", "checkpoint.pt", "curve.csv", "curve.png",
                "manifest.json", "policy.npz", "task.yaml", "training.yaml",
                "used.scenario.yaml",
            },
        )  # fmt: skip


if __name__ == "__main__":
    unittest.main()
