"""PID of pose and force against responses in closed form."""

import unittest

import numpy as np

from brace_drake.laws.control import pid

H = 1e-3


class Loop:
    """PID on one coordinate; what it is joined to is up to the test."""

    def __init__(self, kp=0.0, ki=0.0, kd=0.0, limit=1e9):
        self.law = np.zeros((pid.NUM_PID_LAW, 1))
        self.law[0:4, 0] = kp, ki, kd, limit
        self.memory, self.F = np.zeros((1, 1)), np.empty(1)
        self.saturated = False

    def control_force(self, wanted, kp, ki):
        self.law[4:8, 0] = 1.0, wanted, kp, ki
        return self

    def tick(self, desired=0.0, X=0.0, V=0.0, force=0.0, desired_rate=0.0):
        pid.advance_pid(
            np.array([[desired], [desired_rate], [0.0]]),
            np.array([[X], [V]]), np.array([force]), H, self.saturated,
            self.law, np.array([8.3]), self.memory, self.F,
        )  # fmt: skip
        return self.F[0] - 8.3


class TestPose(unittest.TestCase):
    def test_the_three_parts_and_the_weight_add_up(self):
        loop = Loop(kp=100.0, ki=30.0, kd=4.0)
        for k in range(1, 11):
            F = loop.tick(desired=0.02, X=0.005, V=-0.1, desired_rate=0.3)
            e, e_d = 0.015, 0.4
            exact = 100.0 * e + 30.0 * H * k * e + 4.0 * e_d
            self.assertAlmostEqual(F, exact, places=12)

    def test_on_a_spring_the_error_is_a_geometric_sequence(self):
        # k X = I + kp e: e_(n+1) = e_n r with r = (k + kp) / (k + kp + h ki).
        k, kp, ki, goal = 500.0, 200.0, 40000.0, 0.01
        loop = Loop(kp=kp, ki=ki)
        errors = []
        for _ in range(40):
            integral = loop.memory[0, 0]
            # The spring is met at rest within the tick: X from this tick's F.
            X = (integral + (kp + H * ki) * goal) / (k + kp + H * ki)
            F = loop.tick(desired=goal, X=X)
            self.assertAlmostEqual(F, k * X, places=10)
            errors.append(goal - X)
        ratio = (k + kp) / (k + kp + H * ki)
        exact = errors[0] * ratio ** np.arange(40)
        np.testing.assert_allclose(errors, exact, rtol=1e-10)
        self.assertAlmostEqual(
            errors[0], goal * k / (k + kp + H * ki), places=15
        )

    def test_integral_stops_at_its_limit_and_comes_back_at_once(self):
        loop = Loop(ki=1000.0, limit=5.0)
        for _ in range(2000):
            F = loop.tick(desired=0.01)
        self.assertEqual(F, 5.0)
        F = loop.tick(desired=-0.01)
        self.assertAlmostEqual(F, 5.0 - 0.01, places=12)

    def test_while_a_leg_is_at_its_limit_the_integral_only_shrinks(self):
        loop = Loop(ki=1000.0)
        for _ in range(100):
            loop.tick(desired=0.01)
        before, loop.saturated = loop.memory[0, 0], True
        loop.tick(desired=0.01)
        self.assertEqual(loop.memory[0, 0], before)
        loop.tick(desired=-0.01)
        self.assertAlmostEqual(loop.memory[0, 0], before - 0.01, places=12)


class TestForce(unittest.TestCase):
    def test_against_a_stiff_torso_the_force_comes_as_a_geometric_sequence(
        self,
    ):
        # The force of a tick is what the last tick asked for.
        kp, ki, wanted = 0.5, 100.0, -4.0
        loop = Loop().control_force(wanted, kp, ki)
        force, off = 0.0, []
        for _ in range(60):
            off.append(wanted - force)
            force = loop.tick(force=force)
        # off+ = -kp off - I with I+ = I + h ki off: two poles.
        A = np.array([[-kp - H * ki, -1.0], [H * ki, 1.0]])
        state, exact = np.array([wanted, 0.0]), []
        for _ in range(60):
            exact.append(state[0])
            state = A @ state
        np.testing.assert_allclose(off, exact, atol=1e-12)
        self.assertLess(abs(off[-1]), 0.1)

    def test_motion_is_damped(self):
        loop = Loop(kd=7.0).control_force(0.0, 0.5, 0.0)
        self.assertAlmostEqual(loop.tick(V=0.2), -1.4, places=12)


if __name__ == "__main__":
    unittest.main()
