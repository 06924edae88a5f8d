"""The vector env beside gymnasium's own, of single envs one after another."""

import pickle
import unittest
import warnings
from functools import partial

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import brace_drake.learning
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.rewards import improved
from brace_drake.learning.subjects import (
    EffectRange,
    SubjectRanges,
    between_patients,
)
from brace_drake.learning.task import LearningTask, full_task
from brace_drake.learning.vector.env import RlpicVectorEnv
from tests.learning_tasks import short_task

MODES = tuple(AutoresetMode)


def with_effects():
    """Friction, for all copies at once, and one that goes copy by copy."""
    ranges = between_patients()
    ranges.effects = [
        EffectRange("coulomb_friction", "", 0.5, {"coulomb_N": [0.2, 1.0]}),
        EffectRange("relaxation"),
    ]
    return ranges


class TestSingleEnvs(unittest.TestCase):
    """Everything that comes back is what single envs give, bit for bit."""

    def compare(self, task, n, steps=9, mode=AutoresetMode.NEXT_STEP):
        one = SyncVectorEnv([partial(RlpicEnv, task)] * n, autoreset_mode=mode)
        all_at_once = RlpicVectorEnv(n, task, mode)
        self.agree(one.reset(seed=3), all_at_once.reset(seed=3))
        generator = np.random.default_rng(0)
        ends = 0
        for _ in range(steps):
            actions = generator.uniform(-1.2, 1.2, one.action_space.shape)
            results = [e.step(actions) for e in (one, all_at_once)]
            self.agree(*results)
            ended = results[0][2] | results[0][3]
            ends += ended.sum()
            if mode == AutoresetMode.DISABLED and ended.any():
                reset = [
                    e.reset(options={"reset_mask": ended.copy()})
                    for e in (one, all_at_once)
                ]
                self.agree(*reset)
        return ends

    def agree(self, expected, found):
        self.assertEqual(len(expected), len(found))
        for a, b in zip(expected, found, strict=True):
            self.assertTrue(data_equivalence(a, b, exact=True), f"{a}\n{b}")

    def test_one_stage_in_every_mode_of_autoreset(self):
        for mode in MODES:
            # Six do not fill two fours.
            task = short_task(4, subjects=between_patients(), readings="noisy")
            with self.subTest(mode=mode):
                self.assertGreaterEqual(self.compare(task, 6, mode=mode), 6)

    def test_episodes_that_end_one_by_one(self):
        for mode in MODES:
            task = short_task(20, subjects=between_patients())
            task.limits.force[1] = 0.02
            with self.subTest(mode=mode):
                ends = self.compare(task, 5, 25, mode)
                self.assertGreater(ends, 5)

    def test_three_stages(self):
        task = full_task()
        task.max_steps, task.readings = 3, "noisy"
        task.subjects = between_patients()
        self.assertEqual(self.compare(task, 3, 4), 3)

    def test_effects_of_episodes_at_different_times(self):
        task = short_task(12, subjects=with_effects(), readings="noisy")
        task.limits.force[1] = 0.02
        self.assertGreater(self.compare(task, 5, 20), 5)

    def test_the_improved_reward(self):
        self.compare(short_task(4, reward=improved()), 4)

    def test_the_paper_s_whole_episode(self):
        self.assertEqual(self.compare(LearningTask(), 2, 240), 2)

    def test_one_that_breaks_down_leaves_the_others_alone(self):
        task = short_task(20, failure_reward=-5.0)
        one = SyncVectorEnv([partial(RlpicEnv, task)] * 4)
        found = RlpicVectorEnv(4, task)
        for envs in (one, found):
            envs.reset(seed=1)
            envs.step(np.zeros((4, 1)))
        one.envs[2].loop.brace.bodies[4:7] = np.nan
        found._loops._fours[0]._parts[1].poses[0, 4:7, 2] = np.nan
        for actions in np.zeros((4, 4, 1)):
            self.agree(one.step(actions), found.step(actions))
        actions[1] = np.nan
        self.agree(one.step(actions), found.step(actions))

    def test_a_subject_that_is_asked_for(self):
        task = short_task(3, subjects=between_patients())
        one = SyncVectorEnv([partial(RlpicEnv, task)] * 3)
        found = RlpicVectorEnv(3, task)
        for seed in ([5, None, 9], None):
            results = [
                e.reset(seed=[4, 5, 6] if seed is None else seed,
                        options={"nominal": True})
                for e in (one, found)
            ]  # fmt: skip
            if seed is None:
                self.agree(*results)
            self.assertEqual(results[1][1]["subject"]["preload"][1], 1.0)


class TestVectorEnv(unittest.TestCase):
    def test_make_vec_finds_it(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error", UserWarning)
            for name, size in (("ENV_ID", (3, 7)), ("FULL_ENV_ID", (3, 90))):
                envs = gymnasium.make_vec(
                    getattr(brace_drake.learning, name), num_envs=3
                )
                self.assertIsInstance(envs.unwrapped, RlpicVectorEnv)
                self.assertEqual(envs.observation_space.shape, size)
                observations, _ = envs.reset(seed=0)
                self.assertIn(observations, envs.observation_space)
                envs.close()

    def test_on_the_diagram_they_go_one_by_one(self):
        envs = gymnasium.make_vec(
            brace_drake.learning.ENV_ID,
            num_envs=2,
            task=short_task(backend="diagram"),
            autoreset_mode="SameStep",
        )
        self.assertIsInstance(envs, SyncVectorEnv)
        self.assertEqual(envs.autoreset_mode, AutoresetMode.SAME_STEP)

    def test_wrappers_of_gymnasium_take_it(self):
        task = short_task(3)
        envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(
            gymnasium.make_vec(
                brace_drake.learning.ENV_ID, num_envs=2, task=task
            ),
            stats_key="statistics",
        )
        envs.reset(seed=0)
        for _ in range(3):
            *_, infos = envs.step(np.zeros((2, 1)))
        np.testing.assert_allclose(
            infos["statistics"]["r"], infos["episode"]["r"], rtol=1e-12
        )

    def test_snapshots_lead_back_bit_for_bit(self):
        task = short_task(7, subjects=with_effects(), readings="noisy")
        envs, twin = RlpicVectorEnv(5, task), RlpicVectorEnv(5, task)
        envs.reset(seed=2)
        # So that they are at different places of their episodes.
        mask = np.array([True, False, False, True, False])
        rows, before = np.random.default_rng(1).uniform(-1, 1, (9, 5, 1)), None
        for k, actions in enumerate(rows):
            if k == 3:
                envs.reset(options={"reset_mask": mask})
            if k == 5:
                twin.reset(seed=77)
                kept = pickle.loads(pickle.dumps(envs.Snapshot()))
                last = twin.Restore(kept)
                np.testing.assert_array_equal(last, before)
            before = envs.step(actions)[0]
            if k >= 5:
                np.testing.assert_array_equal(twin.step(actions)[0], before)

    def test_mistakes_of_programs_are_named(self):
        envs = RlpicVectorEnv(2, short_task(1), "Disabled")
        with self.assertRaisesRegex(gymnasium.error.ResetNeeded, "episode 0"):
            envs.step(np.zeros((2, 1)))
        for options, text in (
            ({"color": 1}, "nominal"),
            ({"reset_mask": np.zeros(2, bool)}, "reset_mask"),
            ({"reset_mask": [True, True]}, "reset_mask"),
        ):
            with self.assertRaisesRegex(ValueError, text):
                envs.reset(options=options)
        with self.assertRaisesRegex(ValueError, "3 seeds; allowed: 2"):
            envs.reset(seed=[1, 2, 3])
        envs.reset(seed=0)
        with self.assertRaisesRegex(ValueError, "shape"):
            envs.step(np.zeros((3, 1)))
        envs.step(np.zeros((2, 1)))
        with self.assertRaises(gymnasium.error.ResetNeeded):
            envs.step(np.zeros((2, 1)))
        with self.assertRaisesRegex(ValueError, "preload"):
            RlpicVectorEnv(2, short_task(subjects=SubjectRanges(
                preload=np.zeros(2))))  # fmt: skip


if __name__ == "__main__":
    unittest.main()
