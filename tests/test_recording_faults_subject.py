"""Another subject is told where the motion is not another one as well."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.recording_faults.against_twin.alike import moves_alike
from tests.test_axis_follower import make_campaign
from tests.test_recording_faults_undone import judged_alone

_TIME = np.arange(0.0, 10.0, 0.01)


def odd_one(odd, moved=1.0):
    """Runs of one joint, but for the second run, which is of another one.

    Args:
        odd: Numbers of that joint.
        moved: How many times as far that run goes.
    """
    sound = make_campaign(gains=_GAINS, rest=0.0)
    other = make_campaign(gains=_GAINS, rest=0.0, size=moved, **odd)
    runs = list(sound.runs)
    runs[1] = other.runs[1]
    return replace(sound, runs=tuple(runs))


_GAINS = ((4.0, "fit"), (5.0, "fit"), (6.0, "fit"), (5.0, "validation"))


class TestMotions(unittest.TestCase):
    def test_a_phase_makes_no_other_motion(self):
        self.assertTrue(moves_alike(np.sin(_TIME), np.sin(_TIME + 1.0)))
        self.assertTrue(moves_alike(np.sin(_TIME), 1.5 * np.sin(_TIME)))

    def test_size_speed_and_steps_do(self):
        sine = np.sin(2.0 * _TIME)
        for other in (3.0 * sine, np.sin(6.0 * _TIME), np.sign(sine)):
            self.assertFalse(moves_alike(sine, other))
            self.assertFalse(moves_alike(other, sine))


class TestSubjects(unittest.TestCase):
    def named(self, campaign):
        found = judged_alone(campaign)
        return [(f.fault.name, f.runs, f.is_certain) for f in found]

    def test_a_joint_of_another_lag_in_a_run_like_the_others_is_told(self):
        found = self.named(odd_one({"lag": 0.1}))
        self.assertEqual(found, [("other_subject", ("run1.csv",), True)])

    def test_in_a_run_that_goes_farther_it_may_be_the_motion(self):
        found = self.named(odd_one({"lag": 0.1}, moved=3.0))
        self.assertEqual(found, [("contradiction", ("run1.csv",), False)])


if __name__ == "__main__":
    unittest.main()
