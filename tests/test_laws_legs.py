"""Leg kinematics against finite differences and its own inverse."""

import unittest

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis

from brace_drake.laws import legs
from brace_drake.laws.rotation import (
    quaternion_to_matrix,
    quaternion_to_rotation_vector,
    rotate_quaternion,
)
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import pack_bench

NUMBERS = pack_bench(BenchScenario())


def some_pose(generator):
    """A pose within 10 mm and 0.1 rad of rest: p (3,), q (4,)."""
    q = np.array([1.0, 0.0, 0.0, 0.0])
    rotate_quaternion(q, *generator.uniform(-0.1, 0.1, 3))
    return NUMBERS.rest[0] + generator.uniform(-0.01, 0.01, 3), q


def kinematics(p, q):
    R, lengths, J = np.empty((3, 3)), np.empty(6), np.empty((6, 6))
    quaternion_to_matrix(q, R)
    legs.calc_leg_kinematics(
        p, R, NUMBERS.lower[0], NUMBERS.upper[0], lengths, J
    )
    return lengths, J


class TestLegs(unittest.TestCase):
    def setUp(self):
        self.generator = np.random.default_rng(5)

    def test_jacobian_is_the_derivative_of_the_lengths(self):
        step = 1e-6
        for _ in range(5):
            p, q = some_pose(self.generator)
            _, J = kinematics(p, q)
            difference = np.empty((6, 6))
            for i in range(6):
                ends = []
                for sign in (1.0, -1.0):
                    d = np.zeros(6)
                    d[i] = sign * step
                    turned = q.copy()
                    rotate_quaternion(turned, *d[3:6])
                    ends.append(kinematics(p + d[0:3], turned)[0])
                difference[:, i] = (ends[0] - ends[1]) / (2 * step)
            # Central differences: step^2 over a leg's length.
            np.testing.assert_allclose(J, difference, atol=1e-9)

    def test_forward_kinematics_undoes_leg_lengths(self):
        for _ in range(20):
            p, q = some_pose(self.generator)
            lengths, _ = kinematics(p, q)
            found_p = NUMBERS.rest[0].copy()
            found_q = np.array([1.0, 0.0, 0.0, 0.0])
            self.assertTrue(
                legs.solve_forward_kinematics(
                    lengths,
                    NUMBERS.lower[0],
                    NUMBERS.upper[0],
                    found_p,
                    found_q,
                )
            )
            np.testing.assert_allclose(found_p, p, rtol=0, atol=1e-9)
            found_q /= np.linalg.norm(found_q)
            np.testing.assert_allclose(found_q, q, rtol=0, atol=1e-9)

    def test_impossible_lengths_are_refused(self):
        p, q = NUMBERS.rest[0].copy(), np.array([1.0, 0, 0, 0])
        self.assertFalse(
            legs.solve_forward_kinematics(
                np.array([0.01, 9, 0.01, 9, 0.01, 9]),
                NUMBERS.lower[0],
                NUMBERS.upper[0],
                p,
                q,
            )
        )

    def test_the_wrench_does_the_work_of_the_leg_forces(self):
        p, q = some_pose(self.generator)
        _, J = kinematics(p, q)
        f, V = self.generator.normal(size=6), self.generator.normal(size=6)
        F, rates = np.zeros(6), np.empty(6)
        legs.add_leg_wrench(J, f, F)
        legs.calc_leg_rates(J, V[0:3], V[3:6], rates)
        self.assertAlmostEqual(F @ V, f @ rates, places=12)


class TestRotation(unittest.TestCase):
    def test_rotation_vector_is_that_of_drake(self):
        generator = np.random.default_rng(6)
        for angle in (1e-9, 1e-3, 0.5, 3.0):
            axis = generator.normal(size=3)
            axis /= np.linalg.norm(axis)
            q = AngleAxis(angle, axis).quaternion().wxyz()
            r = np.empty(3)
            for scale in (1.0, -1.7):
                # Of any norm and sign.
                quaternion_to_rotation_vector(scale * q, r)
                np.testing.assert_allclose(
                    r, angle * axis, rtol=1e-12, atol=1e-20
                )


if __name__ == "__main__":
    unittest.main()
