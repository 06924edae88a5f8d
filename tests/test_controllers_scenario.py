"""Numbers of the controllers: files, ranges, and the stability they need."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.laws.control import brace_control
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import pack_bench
from brace_drake.scenario.control_numbers import (
    pack_control,
    parse_coordinates,
    spread,
)
from brace_drake.scenario.controllers import TAGS, BraceControl
from brace_drake.scenario.load import LoadScenario
from brace_drake.scenario.stability import (
    check_control,
    damping_range,
    filter_margin,
    highest_stiffness,
    spectral_radius,
)
from tests.brace_loop import bench_rings
from tests.test_brace_controllers import three_rings

RINGS = bench_rings(pack_bench(BenchScenario()))


class TestLoad(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.path = folder / "some.scenario.yaml"

    def load(self, text, overrides=None, stages="[2]"):
        """Numbers of a brace, of the bench's one stage if not said otherwise.

        The plant's step is a whole part of every period that is tried.
        """
        inner = text if text.startswith("{") else f"{{{text}}}"
        head = f"device: brace\ntime_step: 1.0e-4\nstages: {stages}\n"
        self.path.write_text(f"{head}control: {inner}\n")
        return LoadScenario(self.path, overrides).control

    def test_what_a_file_leaves_out_has_the_default(self):
        control = self.load("{tag: npic, npic: {kappa: 0.2}}")
        self.assertEqual((control.tag, control.npic.kappa), ("npic", 0.2))
        self.assertEqual(control.npic.forgetting, 0.999)
        np.testing.assert_array_equal(control.impedance.mass, [2, 2, 2])

    def test_an_override_takes_another_controller_of_the_same_file(self):
        text = "{tag: pic, impedance: {stiffness: [5e3, 5e3, 5e3]}}"
        control = self.load(text, "control: {tag: vpic}")
        self.assertEqual(control.tag, "vpic")
        np.testing.assert_array_equal(control.impedance.stiffness, 5e3)

    def test_defaults_pass_for_every_tag_on_one_ring_and_on_three(self):
        for tag in TAGS:
            for rings in (RINGS, three_rings()):
                check_control(BraceControl(tag=tag), rings)

    def test_the_papers_gains_pass(self):
        text = "inner: {kp: [6500, 6500, 6500, 6500, 6500, 6500],"
        text += " kd: [1000, 1000, 1000, 1000, 1000, 1000]}"
        self.assertEqual(self.load(text).inner.kd[0], 1000.0)

    def test_all_rings_may_have_numbers_of_their_own(self):
        text = "impedance: {mass: [1, 1, 1, 2, 2, 2, 3, 3, 3]}"
        control = self.load(text, stages="[1, 2, 3]")
        row = pack_control(control, three_rings()).law[brace_control.M_D]
        np.testing.assert_array_equal(row[[0, 3, 6, 9, 14]], [1, 0, 2, 0, 3])

    def test_bad_files_are_told_in_one_line(self):
        six = "[9e4, 9e4, 9e4, 9e4, 9e4, 9e4]"
        cases = {
            "tag: pd": ("tag", "'pd'", "pic or idc", "did you mean"),
            "npic: {kapa: 1}": ("npic.kapa", "kappa"),
            "npic: {kappa: 1}": ("npic.kappa is 1", "0 to 0.95"),
            "npic: {forgetting: 1.1}": ("npic.forgetting", "0.9 to 1"),
            "npic: {covariance_limit: 2}": ("npic.covariance_limit", "3"),
            "npic: {filter_hz: 100}": ("npic.filter_hz", "50 Hz"),
            "rate: -5": ("control.rate is -5", "100 to 20000 Hz"),
            "rate: fast": ("rate", "'fast'", "a number"),
            "rate: .nan": ("rate", "nan", "finite"),
            "estimation: {velocity_cutoff_hz: 900}": ("500 Hz",),
            "estimation: {force_filter_tau: 0}": ("greater than 0",),
            "impedance: {mass: [2, -2, 2]}": ("impedance.mass", "-2", "0"),
            "impedance: {mass: [2, 2]}": ("impedance.mass", "3 numbers"),
            "impedance: {stiffness: 6000}": ("impedance.stiffness", "a list"),
            "impedance: {coordinates: [rx]}": ("coordinates", "'rx'", "x, y"),
            "impedance: {coordinates: [y2]}": ("'y2'", "1 to 1"),
            "impedance: {coordinates: [y, y]}": ("coordinates", "each once"),
            "impedance: {stiffness: [1, 2e6, 1]}": (
                "impedance.stiffness", "less than 1.373e+06 N/m",
            ),
            f"inner: {{kd: {six}}}": ("inner.kd", "stable loop", "1000 Hz"),
            "inner: {kd: [0, 0, 0, 0, 0, 0]}": ("inner.kd", "stable loop"),
            "inner: {kd: [9e11, 9, 9, 9, 9, 9]}": ("inner.kd", "stable loop"),
            "inner: {kd: [9e307, 9, 9, 9, 9, 9]}": ("inner.kd", "1e+12"),
            "{tag: pid, pid: {ki: [9e6, 9e6, 9e6, 9e6, 9e6, 9e6]}}": (
                "pid.kd", "stable",
            ),
            "pid: {integral_limit: [-1, 1, 1, 1, 1, 1]}": ("integral_limit",),
            "{tag: mraic, mraic: {rates: [0, 9, 9]}}": ("rates", "6.28"),
            "{tag: mraic, mraic: {upper: [1, 50, 2]}}": ("mraic.upper", "mass"),
            "{tag: vpic, vpic: {lower: 7000}}": (
                "impedance.stiffness", "7000 to 50000 N/m",
            ),
            "{tag: vpic, vpic: {upper: 2e6}}": ("vpic.upper", "1.373e+06"),
            "vpic: {upper: 400}": ("vpic.upper is 400", "vpic.lower, 500"),
            "vpic: {alpha_share: 1.2}": ("vpic.alpha_share", "0.01 to 0.99"),
        }  # fmt: skip
        for text, parts in cases.items():
            with self.subTest(text=text):
                with self.assertRaises(ScenarioError) as caught:
                    self.load(text)
                message = str(caught.exception)
                self.assertNotIn("\n", message)
                for part in ("some.scenario.yaml", *parts):
                    self.assertIn(part, message)

    def test_a_stiffness_range_in_which_energy_may_grow_is_refused(self):
        # A soft, hardly damped filter at a slow tick.
        text = "{tag: vpic, rate: 200, impedance: {damping_ratio: 0.05}}"
        with self.assertRaisesRegex(ScenarioError, r"vpic\.upper.*N/m"):
            self.load(text)

    def test_the_key_within_a_larger_file_is_named(self):
        control = BraceControl(rate=10.0)
        told = r"a\.yaml: control\.rate is 10\.0; allowed: 100 to 20000"
        with self.assertRaisesRegex(ScenarioError, told):
            check_control(control, RINGS, "a.yaml", "control")


class TestSampledLoops(unittest.TestCase):
    def decays(self, kp, kd, ki, gain, period):
        """Whether the loop, stepped one tick after another, dies away."""
        x, v, before, V, integral = 1.0, 0.0, 1.0, 0.0, 0.0
        sizes = []
        for _ in range(30000):
            V += gain * ((x - before) / period - V)
            before = x
            integral += period * ki * x
            a = -kp * x - kd * V - integral
            x += period * v + 0.5 * period**2 * a
            v += period * a
            sizes.append(abs(x))
            if abs(x) > 1e6:
                return False
        return max(sizes[-2000:]) < 0.5 * max(sizes[:2000])

    def test_poles_say_what_a_stepped_loop_does(self):
        generator, h, seen = np.random.default_rng(9), 1e-3, set()
        for _ in range(14):
            kp = np.exp(generator.uniform(np.log(500), np.log(3e5)))
            kd = np.exp(generator.uniform(np.log(5), np.log(4e3)))
            ki = kp * kd * generator.uniform(0.0, 1.5)
            radius = spectral_radius(kp, kd, ki, 0.22, h)
            if abs(radius - 1.0) < 1e-3:
                continue
            stable = self.decays(kp, kd, ki, 0.22, h)
            self.assertEqual(stable, radius < 1.0, (kp, kd, ki, radius))
            seen.add(stable)
        self.assertEqual(seen, {True, False})

    def test_the_range_of_damping_is_where_poles_are_inside(self):
        low, high = damping_range(6500.0, 0.0, 0.22, 1e-3)
        for kd, stable in (
            (1.05 * low, True), (0.9 * low, False),
            (0.95 * high, True), (1.1 * high, False),
        ):  # fmt: skip
            radius = spectral_radius(6500.0, kd, 0.0, 0.22, 1e-3)
            self.assertEqual(radius < 1.0, stable)
        self.assertIsNone(damping_range(1e9, 0.0, 0.22, 1e-3))

    def test_the_filter_is_stable_up_to_its_highest_stiffness(self):
        M, ratio, h = 2.0, 0.7, 1e-3
        most = highest_stiffness(M, ratio, h)
        for K, stable in ((0.99 * most, True), (1.01 * most, False)):
            C = 2 * ratio * np.sqrt(M * K)
            step = [[1 - h * h * K / M, h * (1 - h * C / M)]]
            step.append([-h * K / M, 1 - h * C / M])
            radius = np.abs(np.linalg.eigvals(step)).max()
            self.assertEqual(radius < 1.0, stable)
            self.assertEqual(filter_margin(M, C, K, h) > 0.0, stable)


class TestArrays(unittest.TestCase):
    def test_coordinates_are_named_by_axis_and_ring(self):
        mask = parse_coordinates(["y", "x3"], 3)
        self.assertEqual(list(np.flatnonzero(mask)), [1, 7, 12, 13])
        for bad in ("w", "y0", "y4", "", "yy", "y-1"):
            with self.assertRaises(ValueError):
                parse_coordinates([bad], 3)

    def test_values_of_one_ring_are_those_of_all(self):
        np.testing.assert_array_equal(
            spread([1, 2, 3], 2, 3), [1, 2, 3, 0, 0, 0] * 2
        )
        np.testing.assert_array_equal(spread(range(6), 2), list(range(6)) * 2)

    def test_a_brace_of_two_rings_takes_six_translations(self):
        np.testing.assert_array_equal(
            spread([1, 2, 3, 4, 5, 6], 2, 3),
            [1, 2, 3, 0, 0, 0, 4, 5, 6, 0, 0, 0],
        )

    def test_damping_of_the_bench_is_that_of_the_paper(self):
        law = pack_control(BraceControl(), RINGS).law
        self.assertAlmostEqual(
            law[brace_control.C_D, 1], 219.0890230020664, places=12
        )


if __name__ == "__main__":
    unittest.main()
