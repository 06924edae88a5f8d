"""What a twin remembers is what it would compute."""

import pickle
import unittest

import numpy as np

from brace_drake.devices.bench.rollout import Motion
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.run_memory import RunMemory
from brace_drake.effects.registry import effects_for
from brace_drake.scenario.brace import BenchScenario
from tests.synthetic_bench import reference, strength_of


def twin():
    return BenchTwin(BenchScenario(), 1e-3 / 3.0)


class TestBenchTwin(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        desired = reference(0.4, -0.004, 0.002)
        cls.motions = [Motion(desired, contact) for contact in (False, True)]
        nominal = np.array([p.nominal for p in twin().subject])
        cls.subjects = [nominal, 1.1 * nominal]

    def test_a_twin_that_remembers_replays_as_one_that_does_not(self):
        cards = effects_for(BenchScenario().device)
        old = twin()
        for motion in self.motions:
            for subject in self.subjects:
                old.simulate(motion, subject)
        for key, card in cards.items():
            values = card.in_run(strength_of(card, 5), 0)
            for motion in self.motions:
                for subject in self.subjects:
                    uses = [(card, values)]
                    with self.subTest(effect=key, contact=motion.with_torso):
                        np.testing.assert_array_equal(
                            old.simulate(motion, subject, uses),
                            twin().simulate(motion, subject, uses),
                        )

    def test_without_the_torso_another_subject_is_not_computed_again(self):
        free, push = self.motions
        mine = twin()
        for motion, same in ((free, True), (push, False)):
            logs = [mine.simulate(motion, s) for s in self.subjects]
            self.assertEqual(logs[0] is logs[1], same)

    def test_a_repeat_of_a_motion_is_not_computed_again(self):
        mine, push = twin(), self.motions[1]
        again = Motion(push.desired.copy(), True)
        one, other = (mine.simulate(m, self.subjects[0]) for m in (push, again))
        self.assertIs(one, other)

    def test_noisy_replays_are_all_computed(self):
        mine, logs = twin(), []
        for seed in (1, 2):
            draw = np.random.default_rng(seed)
            logs.append(
                mine.simulate(self.motions[0], self.subjects[0], (), draw)
            )
        self.assertGreater(np.abs(logs[0] - logs[1]).max(), 0.0)

    def test_a_twin_is_sent_without_what_it_remembers(self):
        mine = twin()
        size = len(pickle.dumps(mine._memory))
        mine.simulate(self.motions[0], self.subjects[0])
        self.assertEqual(len(pickle.dumps(mine._memory)), size)


class TestRunMemory(unittest.TestCase):
    def test_the_log_that_was_asked_for_longest_ago_is_forgotten(self):
        memory, computed = RunMemory(2), []

        def ask(key):
            def compute():
                computed.append(key)
                return np.zeros(1)

            memory.recall(key, compute)

        for key in "abacab":
            ask(key)
        self.assertEqual(computed, list("abcb"))


if __name__ == "__main__":
    unittest.main()
