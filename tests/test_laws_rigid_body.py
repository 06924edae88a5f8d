"""One step of a free body: conservation, and Drake's own plant."""

import unittest

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from brace_drake.laws.rigid_body import step_free_body
from brace_drake.laws.rotation import quaternion_to_matrix
from brace_drake.model.brace_plant import AddBracePlant
from brace_drake.scenario.brace import BenchScenario

BODY = np.array([2.0, 0.3, 0.4, 0.6])


def spin(steps, dt, q, p, V, F=None):
    F = np.zeros(6) if F is None else F
    for _ in range(steps):
        step_free_body(q, p, V, BODY, F, dt)


def angular_momentum_and_energy(q, V):
    R = np.empty((3, 3))
    quaternion_to_matrix(q, R)
    inertia = R @ np.diag(BODY[1:4]) @ R.T
    return inertia @ V[0:3], 0.5 * V[0:3] @ inertia @ V[0:3]


class TestFreeBody(unittest.TestCase):
    def state(self):
        q = np.array([1.0, 0.0, 0.0, 0.0])
        return q, np.zeros(3), np.array([0.5, 1.0, -0.7, 0.1, 0.2, 0.3])

    def test_tumbling_keeps_momentum_and_energy_to_first_order(self):
        drifts = []
        for dt in (2e-4, 1e-4):
            q, p, V = self.state()
            before = angular_momentum_and_energy(q, V)
            spin(round(1.0 / dt), dt, q, p, V)
            after = angular_momentum_and_energy(q, V)
            drifts.append(
                [
                    np.linalg.norm(after[0] - before[0]),
                    abs(after[1] - before[1]),
                ]
            )
        self.assertLess(max(drifts[1]), 1e-4)
        # Euler's rule is of first order: half the step, half the drift.
        ratios = np.divide(*drifts)
        np.testing.assert_allclose(ratios, 2.0, atol=0.1)

    def test_without_force_the_centre_moves_straight(self):
        q, p, V = self.state()
        spin(1000, 1e-3, q, p, V)
        np.testing.assert_allclose(p, [0.1, 0.2, 0.3], atol=1e-12)

    def test_a_constant_force_gives_the_sum_of_the_scheme(self):
        q, p, V = self.state()
        V[:] = 0.0
        F = np.array([0, 0, 0, 4.0, 0, 0])
        spin(100, 0.01, q, p, V, F)
        # a = 2 m/s^2; semi-implicit: dt^2 a n (n + 1) / 2.
        self.assertAlmostEqual(V[3], 2.0, places=12)
        self.assertAlmostEqual(p[0], 1e-4 * 2.0 * 100 * 101 / 2, places=12)

    def test_a_torque_about_a_principal_axis_spins_it_up(self):
        q, p, V = self.state()
        V[:] = 0.0
        spin(100, 0.01, q, p, V, np.array([0, 0, 0.3, 0, 0, 0]))
        np.testing.assert_allclose(V[0:3], [0, 0, 0.5], atol=1e-12)

    def test_it_steps_as_drakes_plant_does(self):
        scenario = BenchScenario(time_step=1e-3)
        builder = DiagramBuilder()
        plant = AddBracePlant(builder, scenario)
        simulator = Simulator(builder.Build())
        context = plant.GetMyMutableContextFromRoot(
            simulator.get_mutable_context()
        )
        F = np.array([0.02, -0.01, 0.03, 0.5, 0.2, -0.1] * 2)
        plant.get_applied_generalized_force_input_port().FixValue(context, F)
        start = plant.GetPositionsAndVelocities(context)
        start[14:26] = np.random.default_rng(1).normal(size=12)
        plant.SetPositionsAndVelocities(context, start)
        simulator.AdvanceTo(0.2 - 5e-4)
        end = plant.GetPositionsAndVelocities(context)
        weights = scenario.ring.mass * scenario.gravity, 0.0
        for i, config in enumerate((scenario.ring, scenario.torso)):
            q, p = start[7 * i : 7 * i + 4].copy(), start[7 * i + 4 : 7 * i + 7]
            p, V = p.copy(), start[14 + 6 * i : 20 + 6 * i].copy()
            force = F[6 * i : 6 * i + 6].copy()
            force[5] -= weights[i]
            body = np.array([config.mass, *config.inertia])
            for _ in range(200):
                step_free_body(q, p, V, body, force, 1e-3)
            ours = np.concatenate([q, p, V])
            theirs = np.concatenate(
                [end[7 * i : 7 * i + 7], end[14 + 6 * i : 20 + 6 * i]]
            )
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11)


if __name__ == "__main__":
    unittest.main()
