"""The paper's scenarios, the measures of its Table 1, and `compare`."""

import csv
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.resources import scenario_path
from brace_drake.devices.motions.reference import MakeBraceReference
from brace_drake.experiments import compare
from brace_drake.experiments.scores import FAILED
from brace_drake.model.simulate import BraceLog
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.load import LoadScenario
from tests.commands import run_command
from tests.test_simulate_brace import reference


def load(name):
    return LoadScenario(scenario_path(name))


def made_log(N=2001):
    """Two rings; the second's errors are sines, its force a ramp."""
    time = np.linspace(0.0, 2.0, N)
    wave = np.sin(2.0 * np.pi * time)
    desired, X = np.zeros((N, 3, 2, 6)), np.zeros((N, 2, 6))
    v, force = np.zeros((N, 2, 3)), np.zeros((N, 2, 3))
    X[:, 1, 0], X[:, 1, 1], X[:, 1, 2] = 1e-3 * wave, 2e-3 * wave, 3e-3 * wave
    v[:, 1, 1] = 4e-3 * wave
    force[:, 1, 1] = -3.0 * time / time[-1]
    drive = np.zeros((N, 12))
    drive[5, 7] = -9.0
    rest = {"leg_length": drive, "marker": force[:, 0], "X_v": X}
    return BraceLog(time, drive, force=force, X=X, v=v, desired=desired, **rest)


class TestMeasures(unittest.TestCase):
    def test_sines_and_a_ramp_have_their_known_measures(self):
        found = compare.score_log(made_log(), 1)
        expected = {
            "y_rms": 2e-3 / 2**0.5,
            "vy_rms": 4e-3 / 2**0.5,
            "x_rms": 1e-3 / 2**0.5,
            "z_rms": 3e-3 / 2**0.5,
            "force_rms": 3.0 / 3**0.5,  # of a ramp about its end
            "force_end": -3.0,
            "peak_force": 3.0,
            "peak_drift": 3e-3,
            "start_rate": 4e-3,
        }
        for name, value in expected.items():
            with self.subTest(measure=name):
                ratio = getattr(found, name) / value
                self.assertAlmostEqual(ratio, 1.0, delta=1e-3)
        self.assertAlmostEqual(found.y_end, 0.0)

    def test_limits_are_the_papers(self):
        at = replace(FAILED, peak_force=50.0, peak_drift=0.020)
        self.assertTrue(at.within_limits)
        self.assertFalse(replace(at, peak_force=50.1).within_limits)
        self.assertFalse(replace(at, peak_drift=0.0201).within_limits)

    def test_a_spring_along_the_cubic_has_the_share_of_its_end(self):
        s = np.linspace(0.0, 1.0, 20001)
        cubic = 3.0 * s**2 - 2.0 * s**3
        for values in (cubic, 1.0 - cubic):
            rms = np.sqrt(np.mean(values**2))
            self.assertAlmostEqual(rms, compare.SPRING_SHARE, delta=1e-4)


class TestPaper(unittest.TestCase):
    def test_the_scenarios_hold_the_papers_numbers(self):
        for name, tag in (
            (compare.PAPER_PIC, "pic"),
            (compare.PAPER_EXPERIMENT, "mraic"),
        ):
            s = load(name)
            with self.subTest(name=name):
                self.assertEqual((s.control.tag, s.stages), (tag, [2]))
                self.assertEqual(s.sensors.log_period, 0.05)
                pads = s.contacts[0]
                self.assertEqual(
                    (pads.model, pads.stiffness, pads.damping, pads.preload),
                    ("linear", 6400.0, 150.0, 0.0),
                )
                self.assertEqual(s.torso.mass, 40.0)
                target = s.control.impedance
                self.assertEqual(target.coordinates, ["y"])
                self.assertEqual(
                    (target.mass[1], target.stiffness[1]), (2, 6e3)
                )
                self.assertEqual(target.damping_ratio, 1.0)
        inner = load(compare.PAPER_PIC).control.inner
        np.testing.assert_array_equal(inner.kp[[0, 2, 3, 4, 5]], 6500.0)
        np.testing.assert_array_equal(inner.kd[[0, 2, 3, 4, 5]], 1000.0)
        models = [c.model for c in load(compare.PAPER_BRACE).contacts]
        self.assertEqual(models, ["none", "linear", "none"])

    def test_the_reference_is_the_cubic_between_its_samples_too(self):
        desired = MakeBraceReference(compare.LoadPush(), [2], np.zeros(6))
        self.assertEqual(desired.end_time(), 12.0)
        t = np.linspace(0.0, 12.0, 1001)
        s, rows = t / 12.0, desired.vector_values(t)
        np.testing.assert_allclose(
            rows[1], -0.01 * (3 * s**2 - 2 * s**3), atol=1e-11
        )
        np.testing.assert_allclose(rows[7], -0.005 * (s - s**2), atol=1e-11)
        np.testing.assert_allclose(
            rows[13], -0.01 / 144 * (6 - 12 * s), atol=1e-11
        )
        np.testing.assert_array_equal(np.delete(rows, [1, 7, 13], 0), 0.0)

    def test_both_experiments_end_where_statics_say(self):
        runs = compare.RunPaper()
        self.assertEqual([r.tag for r in runs], ["pic", "mraic"])
        for r in runs:
            found = r.score
            with self.subTest(tag=r.tag):
                self.assertEqual(len(r.log.time), 241)
                self.assertTrue(found.within_limits)
                self.assertLess(found.y_rms, 0.31054e-3)
                self.assertLess(max(found.x_rms, found.z_rms), 0.08e-3)
                # One pad and the posture in series on the ring's way.
                k = 1.0 / (1.0 / 6400.0 + 1.0 / 190.0)
                way = r.log.X[-1, 0, 1]
                self.assertAlmostEqual(
                    found.force_end / (k * way), 1, delta=0.03
                )
        pic = runs[0]
        e = -0.01 - pic.log.X[-1, 0, 1]
        force = pic.score.force_end
        self.assertAlmostEqual(e, force / 6000.0, delta=0.02e-3)
        share = pic.score.force_rms / abs(force)
        self.assertAlmostEqual(share, compare.SPRING_SHARE, delta=0.03)
        reasons = compare.explain_table_1(pic.score, load(compare.PAPER_PIC))
        self.assertEqual(len(reasons), 3)
        # 0.31054 mm at 6000 N/m.
        self.assertIn("a force of 1.86 N rms", reasons[0])


class TestCompare(unittest.TestCase):
    def test_every_controller_gets_its_own_run_of_the_same_push(self):
        runs = compare.compare_controllers(
            BraceScenario(), reference({2: -0.003}, 0.6), ("pic", "idc")
        )
        self.assertEqual([r.ring for r in runs], [1, 1])
        # One is asked to give way to the torso, the other is not.
        pic, idc = (r.log.X_v - r.log.desired[:, 0] for r in runs)
        np.testing.assert_allclose(idc, 0.0, atol=1e-9)
        self.assertGreater(pic[-1, 1, 1], 3e-4)
        pic, idc = (r.score for r in runs)
        self.assertGreater(pic.y_rms, 1.2 * idc.y_rms)
        self.assertGreater(idc.peak_force, pic.peak_force)

    def test_the_command_writes_one_table(self):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "out"
            motion = Path(folder) / "push.csv"
            channels = reference({2: -0.002}, 0.3).channels
            rows = np.column_stack(list(channels.values()))
            np.savetxt(
                motion,
                rows,
                "%.9f",
                ",",
                header=",".join(channels),
                comments="",
            )
            words = ("compare", "--motion", motion, "--out", out)
            code, text, error = run_command(*words, "--controllers", "pid,pic")
            self.assertEqual(code, 0, error)
            with open(out / "comparison.csv", newline="") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual([r["controller"] for r in rows], ["pid", "pic"])
            self.assertTrue(all(r["within_limits"] == "yes" for r in rows))
            self.assertGreater(float(rows[1]["y_rmse_mm"]), 0.0)
            self.assertIn((out / "comparison.md").read_text(), text)
            png = (out / "comparison.png").read_bytes()
            self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")

    def test_problems_are_told_in_one_line(self):
        bench = scenario_path("bench.scenario.yaml")
        for words, part in (
            (("--controllers", "pic,mpc"), "no controller 'mpc'"),
            ((bench,), "this is a 'bench stage 2'"),
        ):
            with tempfile.TemporaryDirectory() as folder:
                out = Path(folder) / "out"
                code, _, error = run_command("compare", *words, "--out", out)
                self.assertEqual(code, 2)
                self.assertEqual(error.count("\n"), 1)
                self.assertIn(part, error)
                self.assertFalse(out.exists())


if __name__ == "__main__":
    unittest.main()
