"""Commands of leg length: the emulated firmware follows, within its limits."""

import unittest

import numpy as np

from brace_drake.kinematics import make_geometry
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.link.protocol.words import Cause, DeviceState, Mode, StateFlag
from tests.link_bench import SCENARIO, Lockstep


def lengths_of(y):
    """Leg lengths (6,) of the ring displaced along y, m."""
    stage = SCENARIO.joints.stage2
    geometry = make_geometry(
        [(stage.lower.radius, stage.lower.angles_deg)],
        [(stage.upper.radius, stage.upper.angles_deg)],
        SCENARIO.ring_heights[1:3],
    )
    return geometry.at(np.array([0.0, y, 0.0, 0.0, 0.0, 0.0]))[0]


def ramp_to(y, seconds):
    """Displacements of a cubic course, one a tick, then as long at rest."""
    s = np.clip(np.arange(round(2000 * seconds)) / (1000 * seconds), 0.0, 1.0)
    return y * s * s * (3.0 - 2.0 * s)


class TestLengths(unittest.TestCase):
    def setUp(self):
        self.bench = Lockstep()
        self.bench.agree()
        self.bench.Arm()

    def send(self, values, mode=Mode.LENGTH):
        """Answers the newest state; whether that was accepted."""
        firmware = self.bench.firmware
        before = firmware.accepted
        fields = {"mode": mode, "tick": firmware.tick_count}
        self.bench.Send("COMMAND", {**fields, "values": tuple(values)})
        return firmware.accepted > before

    def follow(self, course):
        """The ring's true y, and STATE's flags and lengths, at each tick."""
        y, states = [], []
        for values in course:
            self.assertTrue(self.send(values))
            self.bench.run(1)
            y.append(self.bench.plant.bodies[5])
            states.append(self.bench.heard[-1].values)
        return np.array(y), states

    def test_the_ring_goes_where_the_lengths_say_against_the_torso(self):
        course = ramp_to(-0.004, 0.6)
        y, states = self.follow(lengths_of(v) for v in course)
        self.assertEqual(self.bench.firmware.state, DeviceState.ARMED)
        self.assertLess(states[-1].force[1], -3.0)
        self.assertAlmostEqual(np.mean(y[-50:]), -0.004, delta=5e-5)
        self.assertLess(np.abs(y - course).max(), 1e-3)
        clamped = [s.flags & StateFlag.CLAMPED for s in states]
        self.assertFalse(any(clamped))

    def test_a_far_length_is_gone_to_slowly_and_within_the_stroke(self):
        far = np.full(6, DEFAULT.leg_longest + 0.05)
        # All legs longer lift the ring; no pose of rest is near.
        self.bench.plant.with_torso = False
        _, states = self.follow([far] * 1000)
        lengths = np.array([s.leg_length for s in states])
        speeds = np.diff(lengths[::20], axis=0) / 0.02
        self.assertEqual(self.bench.firmware.state, DeviceState.ARMED)
        self.assertLess(np.abs(speeds).max(), 0.7 * DEFAULT.leg_speed)
        self.assertGreater(np.abs(speeds).max(), 0.4 * DEFAULT.leg_speed)
        self.assertTrue(states[-1].flags & StateFlag.CLAMPED)
        np.testing.assert_allclose(
            lengths[-1], DEFAULT.leg_longest - 5e-4, rtol=0, atol=5e-5
        )

    def test_the_mode_stays_from_arming_to_disarming(self):
        rest, hold = lengths_of(0.0), self.bench.plant.hold
        self.assertTrue(self.send(rest))
        self.bench.run(1)
        self.assertFalse(self.send(hold, Mode.FORCE))
        self.bench.Disarm()
        self.bench.run(600)
        self.bench.Arm()
        self.assertTrue(self.send(hold, Mode.FORCE))
        self.bench.run(1)
        self.assertFalse(self.send(rest))
        self.assertFalse(self.send(rest, 7))

    def test_a_device_that_takes_none_refuses_them(self):
        firmware = self.bench.firmware
        firmware.identity = firmware.identity._replace(takes_lengths=False)
        rejected = firmware.rejected
        self.assertFalse(self.send(lengths_of(0.0)))
        self.assertEqual(firmware.rejected, rejected + 1)
        self.assertTrue(self.send(self.bench.plant.hold, Mode.FORCE))

    def test_a_host_that_falls_silent_is_stopped_and_the_ring_released(self):
        self.follow(lengths_of(v) for v in ramp_to(-0.004, 0.3))
        self.bench.run(60)
        self.assertEqual(self.bench.firmware.state, DeviceState.STOPPED)
        self.assertEqual(self.bench.firmware.trip.cause, Cause.WATCHDOG)
        self.bench.run(1000)
        self.assertLess(abs(self.bench.heard[-1].values.force[1]), 1.0)


if __name__ == "__main__":
    unittest.main()
