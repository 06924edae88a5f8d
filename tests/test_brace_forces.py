"""Forces of S stages: of one by hand, and three keep Newton's laws."""

import unittest

import numpy as np
from scipy.spatial.transform import Rotation

from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.ticks import run_forces
from brace_drake.laws.plug_in import make_effects
from brace_drake.laws.rotation import rotate_quaternion
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace


def some_state(generator, rest, turn=0.05):
    """q, p of bodies near rest, then [w; v] of each."""
    poses, V = [], generator.uniform(-0.1, 0.1, 6 * len(rest))
    for p in rest:
        q = np.array([1.0, 0.0, 0.0, 0.0])
        rotate_quaternion(q, *generator.uniform(-turn, turn, 3))
        poses += [q, p + generator.uniform(-0.004, 0.004, 3)]
    return np.concatenate([*poses, V])


def calc(numbers, state, u, with_legs=True):
    """Forces on the bodies, leg lengths, forces on the torso."""
    n = numbers.num_stages
    with_torso = len(state) > 13 * n
    brace = make_brace(numbers, with_torso, with_legs)
    size, at = 7 * (n + with_torso), 7 * n + 7
    brace.bodies[:size] = state[:size]
    brace.bodies[at : at + len(state) - size] = state[size:]
    brace.u[:] = u
    next(run_forces(1e-3, np.zeros(1), numbers, make_effects({}, n), brace))
    F = brace.F[: n + with_torso].ravel()
    return np.concatenate([F, brace.lengths, brace.f_T.ravel()])


def forces_by_hand(numbers, bodies, u, with_torso):
    """What `calc` returns of one stage, in matrices."""
    (p_R, R_R), (p_T, R_T) = (
        (q[4:7], Rotation.from_quat(np.roll(q[0:4], -1)).as_matrix())
        for q in (bodies[0:7], bodies[7:14])
    )
    V_R, V_T = bodies[14:20], bodies[20:26]
    arms = numbers.upper[0] @ R_R.T
    legs = p_R + arms - numbers.lower[0]
    lengths = np.linalg.norm(legs, axis=1)
    n = legs / lengths[:, None]
    rates = (n * (V_R[3:6] + np.cross(V_R[0:3], arms))).sum(axis=1)
    f = (u - numbers.viscous * rates)[:, None] * n
    F_R = np.concatenate([np.cross(arms, f).sum(axis=0), f.sum(axis=0)])
    if not with_torso:
        return np.concatenate([F_R, lengths, np.zeros(3)])
    law, F_T, f_T = numbers.posture, np.zeros(6), np.zeros(3)
    turn = Rotation.from_matrix(R_T).as_rotvec()
    F_T[0:3] = -law[6:9] * turn - law[9:12] * V_T[0:3]
    F_T[3:6] = -law[0:3] * (p_T - numbers.torso_rest) - law[3:6] * V_T[3:6]
    F_T[3:6] += law[12:15]
    k, c, friction, v_s, offset, preload = numbers.contact[0]
    for s in (1.0, -1.0):
        arm, y = s * offset * R_R[:, 1], R_T[:, 1]
        p = p_R + arm - p_T
        v = V_R[3:6] + np.cross(V_R[0:3], arm)
        v = v - V_T[3:6] - np.cross(V_T[0:3], p)
        d = preload + offset - s * p @ y
        N = max(0.0, k * d - c * s * v @ y) if d > 0.0 else 0.0
        slip = v - (v @ y) * y
        speed = np.linalg.norm(slip)
        on_torso = -s * N * y
        on_torso = on_torso + friction * N * np.tanh(speed / v_s) * slip / speed
        f_T += on_torso
        F_T += np.concatenate([np.cross(p, on_torso), on_torso])
        F_R -= np.concatenate([np.cross(arm, on_torso), on_torso])
    return np.concatenate([F_R, F_T, lengths, f_T])


class TestOneStage(unittest.TestCase):
    def test_the_forces_are_those_by_hand(self):
        generator = np.random.default_rng(1)
        scenario = BraceScenario(stages=[2])
        scenario.torso.lean = np.array([0.4, -1.9, 0.3])
        numbers = pack_brace(scenario)
        rest = [numbers.rest[0], numbers.torso_rest]
        loads = []
        for _ in range(50):
            bodies = some_state(generator, rest)
            u = generator.uniform(-20, 20, 6)
            expected = forces_by_hand(numbers, bodies, u, True)
            np.testing.assert_allclose(
                calc(numbers, bodies, u), expected, rtol=1e-12, atol=1e-12
            )
            loads.append(np.abs(expected[18:21]).max())
        self.assertGreater(min(loads), 0.1)

    def test_a_free_ring_has_the_forces_by_hand(self):
        generator = np.random.default_rng(2)
        numbers = pack_brace(BraceScenario(stages=[2]))
        rest = [numbers.rest[0], numbers.torso_rest]
        bodies = some_state(generator, rest)
        ring = np.concatenate([bodies[0:7], bodies[14:20]])
        u = generator.uniform(-20, 20, 6)
        expected = forces_by_hand(numbers, bodies, u, False)
        ours = calc(numbers, ring, u)
        np.testing.assert_allclose(ours, expected, rtol=1e-12, atol=1e-12)


class TestThreeStages(unittest.TestCase):
    def setUp(self):
        self.generator = np.random.default_rng(3)
        scenario = BraceScenario()
        for name in ("stiffness", "damping", "rot_stiffness", "rot_damping"):
            setattr(scenario.torso, f"posture_{name}", np.zeros(3))
        self.numbers = pack_brace(scenario)
        rest = [*self.numbers.rest, self.numbers.torso_rest]
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
        bare = numbers.with_changes(contact=np.zeros((3, 6)))
        F = calc(bare, self.state, u)[0:18].reshape(3, 6)
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
        rest = [*numbers.rest, numbers.torso_rest]
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
        arm = numbers.rest[:, 2] - numbers.torso_rest[2]
        self.assertAlmostEqual(out[18], -(arm * expected).sum(), places=9)


if __name__ == "__main__":
    unittest.main()
