"""Forces of S stages: one stage is the bench, and three keep Newton's laws."""

import unittest

import numpy as np

from brace_drake.laws import legs
from brace_drake.laws.loop import blocks, kernels
from brace_drake.laws.rotation import rotate_quaternion
from brace_drake.scenario.bench_numbers import pack_bench
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace


def some_state(generator, rest, turn=0.05):
    """q, p of bodies near rest, then [w; v] of each."""
    poses, V = [], generator.uniform(-0.1, 0.1, 6 * len(rest))
    for p in rest:
        q = np.array([1.0, 0.0, 0.0, 0.0])
        rotate_quaternion(q, *generator.uniform(-turn, turn, 3))
        poses += [q, p + generator.uniform(-0.004, 0.004, 3)]
    return np.concatenate([*poses, V])


def calc(numbers, state, u, with_pads=True, with_legs=True):
    n = numbers.num_stages
    out = np.full(kernels.num_forces(n, with_work=True), np.nan)
    inputs = np.concatenate([state, u, numbers.force_law])
    kernels.calc_brace(inputs, n, with_pads, with_legs, out)
    return out[: kernels.num_forces(n)]


class TestOneStage(unittest.TestCase):
    """The laws put together as the compiled rollout of the bench has them."""

    def rollout_forces(self, bench, bodies, u, with_torso):
        lengths, rates, f = np.empty(6), np.empty(6), np.empty(6)
        J, F_R, F_T = np.empty((6, 6)), np.zeros(6), np.zeros(6)
        f_T, pose = np.zeros(3), np.zeros(6)
        blocks.calc_ring_kinematics(
            bodies[0:4], bodies[4:7], bodies[14:20],
            bench.p_WB, bench.p_RT, lengths, rates, J,
        )  # fmt: skip
        if with_torso:
            pads = np.empty((2, 17))
            blocks.add_nominal_pads(bodies, bench.contact, pads, F_R, F_T, f_T)
        blocks.calc_leg_forces(u, bench.viscous, rates, f)
        legs.add_leg_wrench(J, f, F_R)
        if with_torso:
            blocks.add_posture(bodies, bench.rest, bench.posture, pose, F_T)
        return np.concatenate([F_R, F_T, lengths, f_T, pose])

    def test_the_forces_are_those_of_the_bench(self):
        generator = np.random.default_rng(1)
        bench = pack_bench(BenchScenario())
        numbers = pack_brace(BraceScenario(stages=[2]))
        loads = []
        for _ in range(50):
            bodies = some_state(generator, [bench.rest, bench.rest])
            u = generator.uniform(-20, 20, 6)
            expected = self.rollout_forces(bench, bodies, u, True)
            np.testing.assert_allclose(
                calc(numbers, bodies, u), expected, rtol=1e-12, atol=1e-12
            )
            loads.append(np.abs(expected[18:21]).max())
        self.assertGreater(min(loads), 0.1)

    def test_a_free_ring_has_the_forces_of_the_bench(self):
        generator = np.random.default_rng(2)
        bench = pack_bench(BenchScenario())
        numbers = pack_brace(BraceScenario(stages=[2]))
        bodies = some_state(generator, [bench.rest, bench.rest])
        ring = np.concatenate([bodies[0:7], bodies[14:20]])
        u = generator.uniform(-20, 20, 6)
        expected = self.rollout_forces(bench, bodies, u, False)[0:18]
        ours = calc(numbers, ring, u, with_pads=False)[0:18]
        np.testing.assert_allclose(ours, expected, rtol=1e-12, atol=1e-12)


class TestThreeStages(unittest.TestCase):
    def setUp(self):
        self.generator = np.random.default_rng(3)
        scenario = BraceScenario()
        for name in ("stiffness", "damping", "rot_stiffness", "rot_damping"):
            setattr(scenario.torso, f"posture_{name}", np.zeros(3))
        self.numbers = pack_brace(scenario)
        rest = [*self.numbers.geometry.rest, self.numbers.torso_rest]
        self.state = some_state(self.generator, rest)
        self.V = self.state[28:].reshape(4, 6)

    def test_inner_forces_cancel(self):
        # Nothing reaches the ground: the lowest legs neither push nor damp.
        numbers = self.numbers
        numbers.viscous[0:6] = 0.0
        u = self.generator.uniform(-20, 20, 18)
        u[0:6] = 0.0
        F = calc(numbers, self.state, u)[0:24].reshape(4, 6)
        p = self.state[:28].reshape(4, 7)[:, 4:7]
        total = F[:, 3:6].sum(axis=0)
        moment = (F[:, 0:3] + np.cross(p, F[:, 3:6])).sum(axis=0)
        np.testing.assert_allclose(total, 0.0, atol=1e-12)
        np.testing.assert_allclose(moment, 0.0, atol=1e-12)
        self.assertGreater(np.abs(F).max(), 1.0)

    def test_legs_bring_the_power_of_their_forces_and_rates(self):
        numbers, step = self.numbers, 1e-6
        u = self.generator.uniform(-20, 20, 18)
        F = calc(numbers, self.state, u, with_pads=False)[0:18].reshape(3, 6)
        power = (F * self.V[0:3]).sum()
        ends = []
        for sign in (1.0, -1.0):
            moved = self.state.copy()
            for i in range(3):
                pose = moved[7 * i : 7 * i + 7]
                rotate_quaternion(pose[0:4], *sign * step * self.V[i, 0:3])
                pose[4:7] += sign * step * self.V[i, 3:6]
            ends.append(calc(numbers, moved, u)[24:42])
        rates = (ends[0] - ends[1]) / (2 * step)
        f = u - numbers.viscous * rates
        self.assertAlmostEqual(power, f @ rates, delta=1e-6 * abs(power))

    def test_each_ring_presses_with_its_own_pads(self):
        scenario = BraceScenario()
        scenario.contact.ring1.model = "none"
        scenario.contact.ring3.preload = 0.003
        numbers = pack_brace(scenario)
        rest = [*numbers.geometry.rest, numbers.torso_rest]
        state = some_state(np.random.default_rng(0), rest, 0.0)
        state[28:] = 0.0
        shift = np.array([0.0, 2e-4, -3e-4])
        poses = state[:28].reshape(4, 7)
        poses[:, 4:7] = rest
        poses[0:3, 5] += shift
        out = calc(numbers, state, np.zeros(18), with_legs=False)
        force = out[42:51].reshape(3, 3)
        # A shift opens one pad as it closes the other: 2 k per metre.
        expected = 2 * 6400.0 * shift * [0, 1, 1]
        np.testing.assert_allclose(force[:, 1], expected, atol=1e-9)
        np.testing.assert_allclose(out[0:18].reshape(3, 6)[:, 3:6], -force)
        # Above and below To the pads turn the torso.
        arm = numbers.geometry.rest[:, 2] - numbers.torso_rest[2]
        self.assertAlmostEqual(out[18], -(arm * expected).sum(), places=9)


if __name__ == "__main__":
    unittest.main()
