"""The paper's push, 10 mm in 12 s against a torso, with every controller."""

import unittest

import numpy as np

from brace_drake.devices.bench.rollout import Motion, simulate_bench
from brace_drake.kinematics import leg_lengths
from brace_drake.laws import stages
from brace_drake.laws.control import brace_control
from brace_drake.laws.control.mraic import step_reference
from brace_drake.laws.rigid_body import step_free_body
from brace_drake.scenario.control_numbers import pack_control
from brace_drake.scenario.controllers import TAGS, BraceControl
from tests.brace_loop import PERIOD, cubic, paper_bench, push
from tests.test_brace_controllers import three_rings

REFERENCE = cubic(PERIOD * np.arange(12000))


def model_error(X, force):
    """rms of e - e_m, m: how far the ring is from the wanted impedance."""
    model, filtered, off = np.zeros(2), 0.0, []
    C = 2.0 * np.sqrt(2.0 * 6000.0)
    for k, e in enumerate(REFERENCE[:, 0] - X[:, 1]):
        filtered += (1.0 - np.exp(-PERIOD / 0.02)) * (force[k, 1] - filtered)
        step_reference(2.0, C, 6000.0, filtered, PERIOD, model)
        off.append(e - model[0])
    return np.sqrt(np.mean(np.square(off)))


class TestPush(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.runs = {tag: push(BraceControl(tag=tag)) for tag in TAGS}

    def test_all_go_there_within_the_papers_limits(self):
        # rms of y, m: what each has to give way at some 1.8 N, and no more.
        most = {"idc": 6e-5, "pid": 6e-5}
        for tag, (X, force, legs, _, _) in self.runs.items():
            e = REFERENCE[:, 0] - X[:, 1]
            with self.subTest(tag=tag):
                self.assertLess(np.sqrt(np.mean(e**2)), most.get(tag, 3.2e-4))
                self.assertLess(np.abs(X[:, :3]).max(), 0.020)
                self.assertLess(np.abs(X[:, [0, 2]]).max(), 1e-4)
                self.assertLess(np.abs(force).max(), 50.0)
                self.assertLess(np.abs(legs).max(), 120.0)
                # 190 N/m of posture behind 12 800 N/m of pads.
                self.assertAlmostEqual(force[-1, 1], -1.85, delta=0.1)

    def test_at_the_end_the_ring_gives_way_by_force_over_stiffness(self):
        for tag in ("pic", "vpic", "npic"):
            X, force, _, _, used = self.runs[tag]
            e = REFERENCE[-1, 0] - X[-1, 1]
            with self.subTest(tag=tag):
                K = used[-1, 2, 1]
                self.assertAlmostEqual(e, force[-1, 1] / K, delta=1e-5)

    def test_adaptation_brings_the_ring_nearer_to_the_wanted_impedance(self):
        off = {
            t: model_error(*self.runs[t][:2]) for t in ("pic", "mraic", "npic")
        }
        self.assertLess(off["mraic"], 0.75 * off["pic"])
        # Small gain: 1 / (1 + kappa) of what it was.
        self.assertAlmostEqual(off["npic"], off["pic"] / 1.5, delta=2e-6)

    def test_noise_of_the_readings_leads_no_adaptation_astray(self):
        for seed, tag in enumerate(("mraic", "npic", "vpic")):
            exact, noisy = (
                self.runs[tag],
                push(BraceControl(tag=tag), seed=seed),
            )
            with self.subTest(tag=tag):
                off = exact[0][:, 1] - noisy[0][:, 1]
                self.assertLess(np.sqrt(np.mean(off**2)), 1e-5)
                ratio = noisy[4][-1, 2, 1] / exact[4][-1, 2, 1]
                self.assertAlmostEqual(ratio, 1.0, delta=0.02)

    def test_force_control_holds_the_force_that_is_wanted(self):
        control = BraceControl(tag="pid")
        control.pid.force_coordinates = ["y"]
        X, force, _, _, _ = push(control)
        np.testing.assert_allclose(force[-500:, 1], -4.0, atol=0.05)
        self.assertLess(np.abs(X[:, [0, 2]]).max(), 1e-4)

    def test_the_learned_stiffness_of_the_paper_tracks_better(self):
        stiff = push(BraceControl(tag="vpic"), stiffness=np.full(6, 49990.0))
        e = REFERENCE[:, 0] - stiff[0][:, 1]
        soft = REFERENCE[:, 0] - self.runs["pic"][0][:, 1]
        self.assertLess(np.sqrt(np.mean(e**2)), 0.5 * np.sqrt(np.mean(soft**2)))
        self.assertEqual(stiff[4][-1, 2, 1], 49990.0)

    def test_pic_makes_the_run_of_the_compiled_bench(self):
        motion = Motion(REFERENCE, with_torso=True, ticks_per_sample=1)
        log = simulate_bench(paper_bench(), motion, 5e-4)
        _, force, legs, virtual, _ = self.runs["pic"]
        np.testing.assert_allclose(legs, log[:, 0:6], atol=1e-8)
        np.testing.assert_allclose(force, log[:, 12:15], atol=1e-8)
        np.testing.assert_allclose(virtual[:, 0, 1], log[:, 18], atol=1e-10)


class TestThreeRings(unittest.TestCase):
    """Three rings in the air, legs with viscous friction between them."""

    def run_brace(self, tag, seconds=2.5, step=5e-4):
        rings = three_rings()
        control = BraceControl(tag=tag)
        numbers = pack_control(control, rings)
        geometry, n = rings.geometry, rings.num_rings
        poses, V, F = np.zeros((n, 7)), np.zeros((n, 6)), np.zeros((n, 6))
        poses[:, 0], poses[:, 4:] = 1.0, geometry.rest
        R, p_WB = np.empty((n, 3, 3)), np.empty((n, 6, 3))
        lengths, rates = np.empty(6 * n), np.empty(6 * n)
        J, J_L = np.empty((n, 6, 6)), np.zeros((n, 6, 6))
        command, held = np.zeros(6 * n), np.zeros(18 * n)
        used, pose, memory = held.copy(), numbers.pose, numbers.memory
        goal = np.zeros((3, 6 * n))
        goals = 1e-3 * np.array([2.0, -5.0, 3.0])
        for k in range(round(seconds / step)):
            stages.calc_kinematics(
                poses, geometry.lower, geometry.upper, R, p_WB, lengths, J, J_L
            )
            if k % 2 == 0:
                for i, distance in enumerate(goals):
                    goal[:, 6 * i + 1] = cubic(k * step, distance, 0.8)
                result = brace_control.advance_brace(
                    numbers.kind, numbers.law, (pose, memory, held, used),
                    np.concatenate([lengths, np.zeros(3 * n)]), goal.ravel(),
                    np.empty(0), command,
                )  # fmt: skip
                self.assertEqual(result, brace_control.GOOD)
            stages.calc_rates(J, J_L, V, rates)
            F[:] = 0.0
            F[:, 5] = -9.81 * rings.mass[:, 0]
            stages.add_wrenches(J, J_L, command - 40.0 * rates, F)
            for i in range(n):
                q, p = poses[i, 0:4], poses[i, 4:7]
                step_free_body(q, p, V[i], rings.mass[i], F[i], step)
        X = np.empty(6 * n)
        stages.calc_task_coordinates(poses, geometry.rest, X)
        np.testing.assert_allclose(lengths, leg_lengths(geometry, X), atol=1e-6)
        return X, goal[0]

    def test_every_controller_brings_all_rings_to_their_goals(self):
        for tag in TAGS:
            with self.subTest(tag=tag):
                X, goal = self.run_brace(tag)
                np.testing.assert_allclose(X, goal, atol=1e-4)


if __name__ == "__main__":
    unittest.main()
