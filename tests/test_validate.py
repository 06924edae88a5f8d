"""`brace-drake validate`: a campaign replayed before and after its fit."""

import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.load import SaveScenario
from tests.commands import run_command


class TestValidate(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """A campaign of a stiffer bench, and the fit that knows it."""
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        truth = BenchScenario(time_step=5e-4)
        truth.torso.posture_stiffness[1] = 1500.0
        truth.contact.ring2.stiffness = 7000.0
        file = cls.folder / "truth.scenario.yaml"
        SaveScenario(truth, file)
        cls.campaign = cls.folder / "made"
        words = ("simulate", file, "--motion", "reversal")
        code, _, error = run_command(*words, "--out", cls.campaign)
        assert code == 0, error
        cls.nominal = cls.folder / "nominal.scenario.yaml"
        SaveScenario(BenchScenario(time_step=5e-4), cls.nominal)
        parameters = [
            {"name": p.name, "value": p.nominal}
            for p in BenchTwin(truth).subject
        ]
        cls.fit = {
            "format": "brace-fit/1",
            "campaign": "made",
            "parameters": parameters,
        }
        (cls.folder / "fit.json").write_text(json.dumps(cls.fit))

    def validate(self, *words, fit="fit.json"):
        out = self.folder / "out"
        return out, run_command(
            "validate", self.campaign, "--out", out, "--fit",
            self.folder / fit, "--scenario", self.nominal, *words,
        )  # fmt: skip

    def test_the_true_subject_leaves_no_error_and_the_start_some(self):
        out, (code, text, error) = self.validate()
        self.assertEqual(code, 0, error)
        document = json.loads((out / "validation.json").read_text())
        found = document["runs"]["fit"]
        self.assertNotIn("validation", document["runs"])
        # The file's 1e-5 N and 1e-8 m, and lengths back to poses.
        self.assertLess(found["force_rmse_N_after"], 1e-3)
        self.assertLess(found["ring_rmse_m_after"], 1e-7)
        self.assertLess(found["torso_rmse_m_after"], 1e-7)
        self.assertGreater(found["force_rmse_N_before"], 0.1)
        # Pads along a line: the network's stiffness is the true one.
        k = document["regression"]["stiffness_N_m"]
        self.assertAlmostEqual(k / 7000.0, 1.0, delta=0.02)
        subject = document["subject"]["contact_stiffness_N_m"]
        self.assertAlmostEqual(subject["before"], k, delta=1.0)
        self.assertEqual(subject["after"], 7000.0)
        self.assertIn("RMSE", text)
        for name in ("replay", "regression", "force"):
            data = (out / f"{name}.png").read_bytes()
            self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")

    def test_problems_are_told_in_one_line(self):
        other = {**self.fit, "campaign": "another"}
        (self.folder / "other.json").write_text(json.dumps(other))
        (self.folder / "text.json").write_text("k = 3")
        (self.folder / "none.json").write_text("{}")
        for words, fit, part in (
            (("--show", "walk"), "fit.json", "no fit run walk in contact"),
            ((), "other.json", "the fit is of 'another'"),
            ((), "text.json", "text.json: is not a fit.json of"),
            ((), "none.json", "none.json: is not a fit.json of"),
        ):
            with self.subTest(part=part):
                _, (code, _, error) = self.validate(*words, fit=fit)
                self.assertEqual(code, 2)
                self.assertEqual(error.count("\n"), 1)
                self.assertIn(part, error)

    def test_a_run_that_is_not_there_is_refused_before_the_fit(self):
        words = ("validate", self.campaign, "--show", "walk", "--out")
        with mock.patch("brace_drake.results.fits.fit") as fit:
            code, _, error = run_command(*words, self.folder / "late")
        fit.assert_not_called()
        self.assertEqual((code, error.count("\n")), (2, 1))
        self.assertIn("no fit run walk", error)
        self.assertFalse((self.folder / "late").exists())


if __name__ == "__main__":
    unittest.main()
