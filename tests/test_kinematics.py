"""Kinematics of stacked stages against differences, inverses and work."""

import unittest

import numpy as np
from scipy.spatial.transform import Rotation

from brace_drake.core.errors import KinematicsError
from brace_drake.kinematics import (
    Workspace,
    find_task_coordinates,
    leg_jacobian,
    leg_lengths,
    make_geometry,
    measure_stages,
    static_leg_forces,
    task_jacobian,
)
from brace_drake.laws import stage_poses, stages

LOWER, UPPER = [-13, 13, 107, 133, 227, 253], [-47, 47, 73, 167, 193, 287]
BRACE = make_geometry(
    [(0.2, LOWER), (0.19, LOWER), (0.18, [-10, 10, 110, 130, 230, 250])],
    [(0.19, UPPER), (0.18, UPPER), (0.17, [-50, 50, 70, 170, 190, 290])],
    [0.0, 0.145, 0.235, 0.295],
)
WORKSPACE = Workspace(stroke=0.05, singular_value=0.3)


def stacked(relative):
    """Task coordinates (18,) from those of each ring on the one below."""
    X, R, p = np.empty(18), Rotation.identity(), np.zeros(3)
    rest = np.vstack([np.zeros(3), BRACE.rest])
    for i, x in enumerate(relative.reshape(3, 6)):
        p = p + R.apply(rest[i + 1] - rest[i] + x[0:3])
        R = R * Rotation.from_rotvec(x[3:6])
        X[6 * i : 6 * i + 3] = p - rest[i + 1]
        X[6 * i + 3 : 6 * i + 6] = R.as_rotvec()
    return X


def some_poses(generator, count):
    """Task coordinates from all over the workspace."""
    found = []
    while len(found) < count:
        span = np.tile([0.03, 0.03, 0.03, 0.3, 0.3, 0.3], 3)
        size = np.repeat(generator.uniform(0, 1, 3), 6)
        X = stacked(size * span * generator.uniform(-1, 1, 18))
        if WORKSPACE.holds(BRACE, X):
            found.append(X)
    return found


def differences(function, X, step=1e-6):
    columns = []
    for d in step * np.eye(len(X)):
        columns.append((function(X + d) - function(X - d)) / (2 * step))
    return np.column_stack(columns)


class TestJacobian(unittest.TestCase):
    def setUp(self):
        self.poses = some_poses(np.random.default_rng(1), 5)

    def test_task_jacobian_is_the_derivative_of_the_lengths(self):
        for X in self.poses:
            numeric = differences(lambda x: leg_lengths(BRACE, x), X)
            # Central differences: step^2 over a leg's length squared.
            np.testing.assert_allclose(
                task_jacobian(BRACE, X), numeric, atol=1e-8
            )

    def test_leg_jacobian_takes_angular_velocities(self):
        def turned(X, d):
            Y = X + d
            for i in range(3):
                at = slice(6 * i + 3, 6 * i + 6)
                R = Rotation.from_rotvec(d[at]) * Rotation.from_rotvec(X[at])
                Y[at] = R.as_rotvec()
            return leg_lengths(BRACE, Y)

        for X in self.poses:
            numeric = differences(lambda d, X=X: turned(X, d), np.zeros(18))
            np.testing.assert_allclose(
                leg_jacobian(BRACE, X), numeric, atol=1e-8
            )

    def test_legs_move_with_the_rings_at_their_ends_alone(self):
        J = leg_jacobian(BRACE, self.poses[0])
        for i in range(3):
            for j in range(3):
                block = J[6 * i : 6 * i + 6, 6 * j : 6 * j + 6]
                with self.subTest(stage=i, ring=j):
                    self.assertEqual(np.any(block), i - 1 <= j <= i)

    def test_compiled_rates_are_the_jacobian_times_the_twists(self):
        X = self.poses[0]
        _, J, J_L = BRACE.at(X)
        V = np.random.default_rng(2).normal(size=(3, 6))
        rates = np.empty(18)
        stages.calc_rates(J, J_L, V, rates)
        force_first = np.roll(V, 3, axis=1).ravel()
        np.testing.assert_allclose(
            rates, leg_jacobian(BRACE, X) @ force_first, atol=1e-14
        )

    def test_a_rotation_vector_turns_as_its_left_jacobian_says(self):
        E = np.empty((3, 3))
        for angle in (1e-9, 9.9e-4, 1.01e-3, 0.4, 2.5):
            r = angle * np.array([0.6, -0.64, 0.48])
            stages.calc_left_jacobian(r, E)

            def spin(r_new, r=r):
                back = Rotation.from_rotvec(r).inv()
                return (Rotation.from_rotvec(r_new) * back).as_rotvec()

            np.testing.assert_allclose(E, differences(spin, r), atol=1e-8)


class TestForwardKinematics(unittest.TestCase):
    def test_it_undoes_leg_lengths_all_over_the_workspace(self):
        worst = 0.0
        for X in some_poses(np.random.default_rng(3), 2000):
            found = find_task_coordinates(BRACE, leg_lengths(BRACE, X))
            worst = max(worst, np.abs(found - X).max())
        self.assertLess(worst, 1e-9)

    def test_any_lengths_within_the_strokes_of_stages_1_and_2_have_a_pose(self):
        # No pose within these strokes is singular; stage 3 has such poses.
        generator = np.random.default_rng(4)
        bottom = make_geometry(
            [(0.2, LOWER), (0.19, LOWER)],
            [(0.19, UPPER), (0.18, UPPER)],
            [0.0, 0.145, 0.235],
        )
        for _ in range(500):
            change = generator.uniform(-0.025, 0.025, 12)
            if generator.random() < 0.3:
                change = 0.025 * np.sign(change)
            lengths = bottom.rest_lengths + change
            X = find_task_coordinates(bottom, lengths)
            np.testing.assert_allclose(
                leg_lengths(bottom, X), lengths, rtol=0, atol=1e-13
            )
            for stage in measure_stages(bottom, X, 0.05):
                self.assertGreater(stage.singular_value, 0.3)

    def test_near_the_start_one_step_suffices(self):
        X = some_poses(np.random.default_rng(5), 1)[0]
        pose = np.empty((3, 7))
        stages.place_rings(X, BRACE.rest, pose)
        # A tick's way at 0.2 m/s.
        lengths = leg_lengths(BRACE, X)[0:6] + 2e-4
        taken = stage_poses.solve_stage_pose(
            lengths, BRACE.lower[0], BRACE.upper[0], pose[0]
        )
        self.assertEqual(taken, 1)

    def test_a_way_through_a_singularity_is_refused(self):
        lengths = BRACE.rest_lengths.copy()
        lengths[0:6] = [0.05, 0.9, 0.05, 0.9, 0.05, 0.9]
        with self.assertRaisesRegex(KinematicsError, "stage 1 from below"):
            find_task_coordinates(BRACE, lengths)

    def test_bad_lengths_are_told(self):
        good = BRACE.rest_lengths
        for bad, words in (
            (good[0:17], r"\(17,\); allowed: \(18,\)"),
            (np.append(good[0:17], np.nan), "not finite"),
            (["long"] * 18, "not numbers"),
        ):
            with self.assertRaisesRegex(KinematicsError, words):
                find_task_coordinates(BRACE, bad)


class TestStatics(unittest.TestCase):
    def test_leg_forces_do_the_work_of_the_wrench_on_any_way(self):
        generator = np.random.default_rng(6)
        for X in some_poses(generator, 20):
            W, V = generator.normal(size=18), generator.normal(size=18)
            f = static_leg_forces(BRACE, X, W)
            work = f @ (leg_jacobian(BRACE, X) @ V)
            self.assertAlmostEqual(
                work, W @ V, delta=1e-10 * np.abs(W @ V) + 1e-10
            )

    def test_a_weight_is_the_rise_of_its_height_along_each_leg(self):
        # Virtual work by differences of heights, without any Jacobian.
        X = some_poses(np.random.default_rng(7), 1)[0]
        weights = np.array([8.0, 7.0, 6.0])
        W = np.zeros((3, 6))
        W[:, 2] = weights
        f = static_leg_forces(BRACE, X, W.ravel())
        lengths = leg_lengths(BRACE, X)

        def energy(lengths):
            heights = find_task_coordinates(BRACE, lengths, X)[2::6]
            return np.array([weights @ heights])

        rise = differences(energy, lengths, 1e-5)[0]
        np.testing.assert_allclose(f, rise, rtol=1e-5, atol=1e-5)

    def test_compiled_wrenches_undo_the_leg_forces(self):
        X = some_poses(np.random.default_rng(8), 1)[0]
        _, J, J_L = BRACE.at(X)
        W = np.random.default_rng(9).normal(size=18)
        F = np.zeros((3, 6))
        stages.add_wrenches(J, J_L, static_leg_forces(BRACE, X, W), F)
        np.testing.assert_allclose(np.roll(F, 3, axis=1).ravel(), W, atol=1e-12)


class TestWorkspace(unittest.TestCase):
    def test_measures_at_rest(self):
        # Independent: numbers of the data sheet's geometry.
        at_rest = measure_stages(BRACE, np.zeros(18), 0.05)
        values = [m.singular_value for m in at_rest]
        np.testing.assert_allclose(values, [1.017, 1.043, 0.738], atol=1e-3)
        self.assertEqual([m.stroke_use for m in at_rest], [0.0] * 3)
        for m in at_rest:
            self.assertGreater(m.condition_number, 1.0)

    def test_stroke_use_is_that_of_the_longest_way(self):
        X = np.zeros(18)
        X[14] = 0.005
        use = measure_stages(BRACE, X, 0.05)[2]
        change = leg_lengths(BRACE, X) - BRACE.rest_lengths
        self.assertAlmostEqual(use.stroke_use, np.abs(change).max() / 0.025)

    def test_a_leg_beyond_its_stroke_is_named(self):
        X = np.zeros(18)
        X[2] = X[8] = X[14] = 0.05
        with self.assertRaisesRegex(
            KinematicsError, "stage 1 from below: leg . is 0.04138 m.*0.025 m"
        ):
            WORKSPACE.check(BRACE, X)

    def test_a_singular_stage_is_named(self):
        # Turned by a quarter, all legs of a symmetric stage meet the axis.
        X = np.zeros(18)
        X[17] = np.pi / 2
        with self.assertRaisesRegex(KinematicsError, "stage 3"):
            Workspace(10.0, 0.3).check(BRACE, X)

    def test_impossible_geometry_is_refused(self):
        circle, up = (0.2, LOWER), (0.19, UPPER)
        for arguments, words in (
            (([circle], [circle], [0.1, 0.1]), "0 m long"),
            (([circle], [(0.1, LOWER)], [0.0, 0.1]), "singular at rest"),
            (([circle], [up], [0.0]), "S \\+ 1"),
            (([circle], [(0.19, UPPER[:5])], [0.0, 0.1]), "six angles"),
        ):
            with self.assertRaisesRegex(KinematicsError, words):
                make_geometry(*arguments)


if __name__ == "__main__":
    unittest.main()
