"""The repairs of Drake's gymnasium env, on a small system of its own."""

import unittest

import gymnasium
import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import EventStatus, LeafSystem

from brace_drake.learning.drake_env import RepairedDrakeGymEnv

STEP, PERIOD = 0.1, 0.01


class Counter(LeafSystem):
    """Sums its input at 100 Hz; can be told to fail or to lose its number."""

    def __init__(self, wrong=None):
        super().__init__()
        self.wrong, self.starts = wrong, []
        self.DeclareVectorInputPort("u", 1)
        state = self.DeclareDiscreteState([0.0, 0.0])
        self.DeclareStateOutputPort("y", state)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self.Add)
        self.DeclareInitializationDiscreteUpdateEvent(self.Start)

    def Start(self, context, discrete):
        u = self.get_input_port().Eval(context)[0]
        x = context.get_discrete_state(0).value()
        self.starts.append((float(u), *map(float, x)))

    def Add(self, context, discrete):
        u = self.get_input_port().Eval(context)[0]
        x = discrete.get_mutable_value(0)
        x[0] += u
        x[1] += 1.0
        if self.wrong == "nan" and x[1] > 12:
            x[0] = np.nan
        if isinstance(self.wrong, BaseException) and x[1] > 12:
            raise self.wrong


def box(size=1, bound=1.0):
    return gymnasium.spaces.Box(-bound, bound, (size,), np.float64)


def total(system, context):
    return system.GetOutputPort("y").Eval(context)[0]


def make(wrong=None, **options):
    """The env, and its system."""
    system = Counter(wrong)
    options.setdefault("reset_handler", lambda simulator, context, seed: None)
    env = RepairedDrakeGymEnv(
        Simulator(system),
        STEP,
        box(),
        box(2, np.inf),
        lambda system, context: float(
            system.GetOutputPort("y").Eval(context)[0]
        ),
        action_port_id="u",
        observation_port_id="y",
        **options,
    )
    return env, system


class TestRepairs(unittest.TestCase):
    def test_info_is_asked_for(self):
        env, _ = make(info_handler=lambda s: {"t": s.get_context().get_time()})
        self.assertEqual(env.reset()[1], {"t": 0.0})
        self.assertAlmostEqual(env.step(np.zeros(1))[-1]["t"], STEP)

    def test_every_step_has_the_same_events(self):
        env, _ = make()
        env.reset()
        seen = [env.step(np.zeros(1))[0][1] for _ in range(400)]
        np.testing.assert_array_equal(seen, 10.0 * np.arange(1, 401))

    def test_failures_and_lost_numbers_end_the_episode(self):
        for wrong, cause in (
            ("nan", "not finite"),
            (RuntimeError("no contact solution"), "no contact solution"),
            (ValueError("bad value"), "ValueError: bad value"),
        ):
            env, _ = make(wrong, failure_reward=-1.0)
            env.reset()
            good = env.step(np.ones(1))[0]
            seen, reward, ended, cut, info = env.step(np.ones(1))
            with self.subTest(cause=cause):
                self.assertEqual((reward, ended, cut), (-1.0, True, False))
                self.assertIn(cause, info["failure"])
                np.testing.assert_array_equal(seen, good)
                with self.assertRaises(gymnasium.error.ResetNeeded):
                    env.step(np.ones(1))

    def test_mistakes_of_programs_are_not_swallowed(self):
        env, _ = make(TypeError("a mistake"))
        env.reset()
        env.step(np.ones(1))
        with self.assertRaisesRegex(TypeError, "a mistake"):
            env.step(np.ones(1))

    def test_a_reset_initializes_the_new_state_with_the_neutral_action(self):
        env, system = make(neutral_action=np.array([0.25]))
        env.reset()
        env.step(np.ones(1))
        env.reset()
        self.assertEqual(system.starts, [(0.25, 0.0, 0.0)] * 2)

    def test_metadata_of_other_envs_is_left_alone(self):
        before = dict(gymnasium.Env.metadata)
        env, _ = make(render_mode="ansi")
        env.metadata["render_modes"] = []
        self.assertEqual(gymnasium.Env.metadata, before)
        self.assertIn("ansi", make()[0].metadata["render_modes"])
        env.reset()
        self.assertIn("Time: 0", env.render())

    def test_spaces_that_checkers_refuse_are_refused_in_words(self):
        for action in (
            None,
            gymnasium.spaces.Discrete(2),
            gymnasium.spaces.Box(-1, 1, (1,), np.float32),
        ):
            with self.assertRaisesRegex(ValueError, "action_space"):
                RepairedDrakeGymEnv(
                    Simulator(Counter()),
                    STEP,
                    action,
                    box(2),
                    lambda s, c: 0.0,
                    action_port_id="u",
                    observation_port_id="y",
                )

    def test_actions_are_cut_and_the_cuts_counted(self):
        env, _ = make()
        env.reset()
        observation, *_, info = env.step(np.array([1e6]))
        self.assertLessEqual(observation[0], 11.0)
        self.assertEqual(info["clipped"], 1)
        with self.assertRaisesRegex(ValueError, "shape"):
            env.step(np.zeros(2))

    def test_a_monitor_ends_the_episode(self):
        env, _ = make()
        env.reset()
        env.simulator.set_monitor(
            lambda context: EventStatus.ReachedTermination(None, "done")
        )
        self.assertTrue(env.step(np.zeros(1))[2])

    def test_without_a_step_before_reset(self):
        with self.assertRaises(gymnasium.error.ResetNeeded):
            make()[0].step(np.zeros(1))


if __name__ == "__main__":
    unittest.main()
