"""RLPIC as a gymnasium env: the two backends, checkers, seeds, failures."""

import pickle
import unittest
import warnings
from functools import partial
from unittest import mock

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

import brace_drake.learning
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.subjects import (
    EffectRange,
    SubjectRanges,
    between_patients,
)
from brace_drake.learning.task import LearningTask, full_task
from tests.learning_tasks import short_task

ACTIONS = np.array([0.9, -0.5, 0.3, 0.1, 1.0, -1.0])


def roll(env, seed=3, actions=ACTIONS):
    """Observations, rewards and stiffness of a few steps."""
    observation, _ = env.reset(seed=seed)
    rows = [observation]
    for a in actions:
        observation, reward, *_, info = env.step(
            np.full(env.action_space.shape, a)
        )
        truth = env.loop.truth()
        rows.append(
            np.concatenate(
                [
                    observation,
                    [reward],
                    info["stiffness"],
                    *truth,
                ]
            )
        )
    return rows


class TestBackends(unittest.TestCase):
    def compare(self, task, atol=1e-8):
        rows = {}
        for backend in ("compiled", "diagram"):
            task.backend = backend
            env = RlpicEnv(task)
            rows[backend] = [roll(env), roll(env, seed=4)]
        for compiled, diagram in zip(*rows.values(), strict=True):
            for a, b in zip(compiled, diagram, strict=True):
                np.testing.assert_allclose(a, b, rtol=1e-8, atol=atol)
        return compiled

    def test_the_compiled_stage_is_its_diagram(self):
        last = self.compare(short_task(len(ACTIONS)))[-1]
        # It has moved and been pushed back.
        self.assertLess(last[2], -1e-6)
        self.assertGreater(last[4], 1e-4)

    def test_with_subjects_noise_and_effects_too(self):
        ranges = between_patients()
        ranges.effects = [
            EffectRange("coulomb_friction", "", 1.0, {"coulomb_N": [0.2, 1.0]}),
            EffectRange("relaxation"),
        ]
        self.compare(
            short_task(len(ACTIONS), subjects=ranges, readings="noisy")
        )

    def test_the_compiled_brace_of_three_stages_is_its_diagram(self):
        task = full_task()
        task.max_steps = len(ACTIONS)
        task.readings = "noisy"
        task.subjects = between_patients()
        self.compare(task)


class TestCheckers(unittest.TestCase):
    def test_gymnasium_finds_nothing_wrong(self):
        for name in ("ENV_ID", "FULL_ENV_ID"):
            env = gymnasium.make(getattr(brace_drake.learning, name))
            with warnings.catch_warnings():
                warnings.simplefilter("error", UserWarning)
                # Observations are of unlimited quantities on purpose.
                warnings.filterwarnings("ignore", ".*infinity.*")
                warnings.filterwarnings("ignore", ".*render.*")
                check_env(env.unwrapped, skip_render_check=True)
            self.assertEqual(env.observation_space.dtype, np.float64)

    def test_stable_baselines_finds_nothing_wrong(self):
        try:
            from stable_baselines3.common.env_checker import check_env as check
        except ImportError:
            self.skipTest("stable-baselines3 is not installed")
        for task in (LearningTask(), full_task()):
            with warnings.catch_warnings():
                warnings.simplefilter("error", UserWarning)
                # Advice: single precision would lose micrometres.
                warnings.filterwarnings("ignore", ".*float64, we recommend.*")
                check(RlpicEnv(task))

    def test_sizes_are_those_of_the_paper(self):
        env = RlpicEnv()
        self.assertEqual(env.observation_space.shape, (7,))
        self.assertEqual(env.action_space.shape, (1,))
        full = gymnasium.make(brace_drake.learning.FULL_ENV_ID)
        self.assertEqual(full.observation_space.shape, (90,))
        self.assertEqual(full.action_space.shape, (9,))
        self.assertEqual((env.task.max_steps, env.time_step), (240, 0.05))


class TestEpisodes(unittest.TestCase):
    def test_seeds_repeat_bit_for_bit(self):
        task = short_task(subjects=between_patients(), readings="noisy")
        env, other = RlpicEnv(task), RlpicEnv(task)
        first = roll(env)
        roll(env, seed=None)
        for rows in (roll(env), roll(other)):
            for a, b in zip(first, rows, strict=True):
                np.testing.assert_array_equal(a, b)
        changed = roll(env, seed=4)[-1]
        self.assertNotEqual(changed[2], first[-1][2])

    def test_it_ends_after_its_steps_and_takes_no_more(self):
        env = RlpicEnv(short_task(2))
        env.reset(seed=0)
        *_, cut, info = env.step(np.zeros(1))
        self.assertFalse(cut)
        self.assertNotIn("episode", info)
        _, reward, ended, cut, info = env.step(np.zeros(1))
        self.assertEqual((ended, cut), (False, True))
        self.assertEqual(info["episode"]["l"], 2)
        self.assertAlmostEqual(sum(info["reward_terms"].values()), reward)
        with self.assertRaises(gymnasium.error.ResetNeeded):
            env.step(np.zeros(1))

    def test_a_passed_limit_ends_it_with_its_cause(self):
        task = short_task(20)
        task.limits.force[1] = 0.01
        env = RlpicEnv(task)
        env.reset(seed=0)
        for _ in range(20):
            *_, ended, cut, info = env.step(np.ones(1))
            if ended or cut:
                break
        self.assertTrue(ended)
        self.assertIn("ring2 y: force", info["cause"])

    def test_a_failure_ends_it_with_a_name_and_not_with_zeros(self):
        for backend in ("compiled", "diagram"):
            task = short_task(20, backend=backend, failure_reward=-5.0)
            env = RlpicEnv(task)
            env.reset(seed=0)
            observation = env.step(np.zeros(1))[0]
            self.tear_apart(env)
            seen, reward, ended, cut, info = env.step(np.zeros(1))
            with self.subTest(backend=backend):
                self.assertEqual((reward, ended, cut), (-5.0, True, False))
                self.assertRegex(info["failure"], "BraceError|NaN")
                np.testing.assert_array_equal(seen, observation)
                # And a reset puts everything right again.
                again = roll(env)
                for a, b in zip(again, roll(RlpicEnv(task)), strict=True):
                    np.testing.assert_array_equal(a, b)

    def tear_apart(self, env):
        """Puts the ring where no leg reaches."""
        if env.task.backend == "compiled":
            env.loop.brace.bodies[4:7] = np.nan
            return
        plant = env.loop.diagram.GetSubsystemByName(
            "station"
        ).GetSubsystemByName("plant")
        context = plant.GetMyMutableContextFromRoot(
            env.loop.simulator.get_mutable_context()
        )
        V = np.full(6, 1e6)
        plant.SetVelocities(context, np.concatenate([V, np.zeros(6)]))

    def test_an_action_that_is_no_number_ends_it(self):
        env = RlpicEnv(short_task())
        env.reset(seed=0)
        *_, ended, _, info = env.step(np.array([np.nan]))
        self.assertTrue(ended)
        self.assertEqual(info["failure"], "the action is not finite")

    def test_numbers_that_are_not_finite_end_it(self):
        env = RlpicEnv(short_task())
        env.reset(seed=0)
        with mock.patch.object(env, "_Observe", lambda: np.full(7, np.nan)):
            seen, _, ended, _, info = env.step(np.zeros(1))
        self.assertTrue(ended and np.isfinite(seen).all())
        self.assertIn("not finite", info["failure"])

    def test_mistakes_of_programs_are_not_swallowed(self):
        env = RlpicEnv(short_task())
        with self.assertRaises(gymnasium.error.ResetNeeded):
            env.step(np.zeros(1))
        env.reset(seed=0)
        with self.assertRaisesRegex(ValueError, "shape"):
            env.step(np.zeros(2))
        mistake = mock.patch.object(env.loop, "advance", side_effect=TypeError)
        with mistake, self.assertRaises(TypeError):
            env.step(np.zeros(1))

    def test_the_diagram_is_drawn(self):
        env = RlpicEnv(short_task(backend="diagram"), "ansi")
        env.reset(seed=0)
        self.assertIn("Time: 0", env.render())

    def test_cut_actions_are_counted(self):
        env = RlpicEnv(short_task())
        env.reset(seed=0)
        env.step(np.array([5.0]))
        info = env.step(np.array([0.5]))[-1]
        self.assertEqual(info["clipped"], 1)

    def test_a_snapshot_leads_back_bit_for_bit(self):
        task = short_task(10, subjects=between_patients(), readings="noisy")
        env = RlpicEnv(task)
        roll(env, actions=ACTIONS[:4])
        snapshot = pickle.loads(pickle.dumps(env.Snapshot()))
        twin = RlpicEnv(task)
        twin.reset(seed=77)
        twin.Restore(snapshot)
        for a in ACTIONS[4:]:
            for x, y in zip(
                env.step(np.array([a]))[:2],
                twin.step(np.array([a]))[:2],
                strict=True,
            ):
                np.testing.assert_array_equal(x, y)
        np.testing.assert_array_equal(env.reset()[0], twin.reset()[0])


class TestTask(unittest.TestCase):
    def test_what_is_not_allowed_is_named(self):
        for change, text in (
            ({"sample_time": 0.0503}, "sample_time"),
            ({"backend": "fast"}, "backend"),
            ({"observation": "some"}, "observation"),
            ({"displacement": np.zeros(5)}, "displacement"),
            ({"scenario": "bench.scenario.yaml"}, "device"),
            ({"subjects": SubjectRanges(preload=np.zeros(2))}, "preload"),
        ):
            task = short_task(**change)
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                RlpicEnv(task)

    def test_subjects_whose_friction_no_step_is_short_enough_for(self):
        wide = SubjectRanges(preload=np.array([1.0, 4.0]))
        # 0.85 kg over 0.35 / 0.005 s/m of 51.2 N.
        with self.assertRaisesRegex(ValueError, "less than 0.000237 s"):
            RlpicEnv(short_task(subjects=wide))

    def test_options_of_a_reset_are_checked(self):
        with self.assertRaisesRegex(ValueError, "nominal"):
            RlpicEnv().reset(options={"color": 1})

    def test_a_maker_pickles(self):
        maker = pickle.loads(pickle.dumps(partial(RlpicEnv, short_task())))
        self.assertEqual(maker().task.max_steps, 6)


class TestProcesses(unittest.TestCase):
    def test_envs_in_processes_are_those_of_one(self):
        maker = partial(RlpicEnv, short_task(subjects=between_patients()))
        env = maker()
        vector = gymnasium.vector.AsyncVectorEnv(
            [maker] * 2, context="forkserver"
        )
        try:
            start, _ = vector.reset(seed=[5, 6])
            step = vector.step(np.zeros((2, 1)))[0]
        finally:
            vector.close()
        for i, seed in enumerate((5, 6)):
            np.testing.assert_array_equal(start[i], env.reset(seed=seed)[0])
            np.testing.assert_array_equal(step[i], env.step(np.zeros(1))[0])


if __name__ == "__main__":
    unittest.main()
