"""The whole way from a recording to diagnosis.json, fit.json and report."""

import json
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from brace_drake.cli.main import main
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.diagnosis import diagnose
from brace_drake.document.document import MakeDocument
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.gap import compare_runs, rms_gap
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording import LoadCampaign, WriteCampaign
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.load import LoadScenario
from tests.shared_data import EXAMPLE, SHARED, needs_shared

# tests/data/README.md: what the example was recorded with.
ARM, TIME = 3928.77, 1.74706
TRUTH = {
    "contact_stiffness_N_m": 0.935663 * 6400.0,
    "contact_damping_N_s_m": 0.973756 * 150.0,
    "posture_stiffness_y_N_m": 0.925677 * 1800.0,
    "posture_damping_y_N_s_m": 0.975008 * 220.0,
    "torso_mass_kg": 1.130869 * 40.0,
    "preload_m": 0.988942e-3,
}
# Motions that a poor recording has not.
LEFT_OUT = ("multisine", "free_multisine", "quiet_hold", "reversal")


def form_of(value):
    """Paths of the keys of a document; items of a list count as one."""
    if isinstance(value, dict):
        return {
            (key, *rest)
            for key, part in value.items()
            for rest in form_of(part)
        } or {()}
    if isinstance(value, list):
        return set().union(*map(form_of, value)) or {()}
    return {()}


def make_poor(campaign):
    """Few runs, 20 Hz, no marker, no repeat, a sample lost, steps cut short."""
    runs = []
    for run in campaign.runs:
        if run.repeat_of is not None or run.motion in LEFT_OUT:
            continue
        end = -1 if run.motion != "stairs" else len(run.time_s) // 2
        channels = {
            name: values[:end:10].copy()
            for name, values in run.channels.items()
            if not name.startswith("torso")
        }
        channels["ring2_force_y_N"][40] = np.nan
        runs.append(replace(run, channels=channels))
    return replace(campaign, runs=tuple(runs), rate_hz=20.0)


class TestExample(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.out = Path(cls.folder.name) / "out"
        cls.code = main(["diagnose", str(EXAMPLE), "--out", str(cls.out)])
        cls.document = json.loads((cls.out / "diagnosis.json").read_text())

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_the_command_ends_well_and_leaves_its_files_only(self):
        self.assertEqual(self.code, 0)
        names = sorted(p.name for p in self.out.iterdir())
        self.assertEqual(
            names, ["diagnosis.json", "repaired.scenario.yaml", "report.html"]
        )

    def test_the_repaired_twin_reloaded_shows_the_gap_after_the_repair(self):
        campaign = LoadCampaign(EXAMPLE)
        scenario = LoadScenario(self.out / "repaired.scenario.yaml")
        nominal, repaired = BenchTwin(BenchScenario()), BenchTwin(scenario)
        nominal_values = np.array([p.nominal for p in nominal.subject])
        floors, _ = estimate_floors(nominal, campaign, nominal_values, 0)
        runs = campaign.split("validation")
        prepared = prepare_runs(repaired, runs, floors, campaign.rate_hz, 1000)
        evaluator = Evaluator(repaired, prepared, 1)
        fitted = np.array([p.nominal for p in repaired.subject])
        twin_alone = SimpleNamespace(subject=fitted, within=())
        runs = compare_runs(evaluator, twin_alone, None)
        self.assertEqual(
            rms_gap(runs, "before"), self.document["shrink"]["after"]
        )

    def test_the_stored_diagnosis_has_the_form_of_one_that_is_written(self):
        path = EXAMPLE.parent / "example_diagnosis" / "diagnosis.json"
        stored = json.loads(path.read_text())
        self.assertEqual(form_of(stored), form_of(self.document))
        for name in ("effects", "blocks", "outside_library"):
            self.assertEqual(
                stored["verdict"][name], self.document["verdict"][name]
            )

    def test_the_relaxing_tissue_is_named_and_placed(self):
        verdict = self.document["verdict"]
        self.assertTrue(verdict["gap"])
        self.assertEqual(verdict["effects"], ["relaxation"])
        self.assertEqual(verdict["blocks"], ["contact"])
        self.assertFalse(verdict["outside_library"])
        self.assertGreater(verdict["probability"], 0.85)

    def test_its_parameters_are_those_of_the_recording(self):
        found = {
            p["name"]: p["value"]
            for p in self.document["causes"][0]["parameters"]
        }
        self.assertAlmostEqual(found["arm_stiffness_N_m"] / ARM, 1, delta=0.2)
        self.assertAlmostEqual(found["relaxation_time_s"] / TIME, 1, delta=0.2)

    def test_the_subject_is_found_beside_the_effect(self):
        for p in self.document["subject"]["parameters"]:
            with self.subTest(parameter=p["name"]):
                # Four standard errors: the fit runs are few, the test is one.
                self.assertAlmostEqual(
                    p["value"],
                    TRUTH[p["name"]],
                    delta=4.0 * p["standard_error"],
                )

    def test_a_poor_recording_is_answered_and_with_less_confidence(self):
        with tempfile.TemporaryDirectory() as folder:
            path, out = Path(folder) / "poor", Path(folder) / "out"
            WriteCampaign(make_poor(LoadCampaign(EXAMPLE)), path)
            self.assertEqual(
                main(["diagnose", str(path), "--out", str(out)]), 0
            )
            document = json.loads((out / "diagnosis.json").read_text())
        whole, poor = self.document["verdict"], document["verdict"]
        self.assertLess(poor["probability"], whole["probability"])
        if poor["effects"] != whole["effects"]:
            self.assertLess(poor["probability"], 0.5)
        warnings = "\n".join(document["warnings"])
        for told in ("torso_y_m", "filled by a straight line", "repeated"):
            self.assertIn(told, warnings)

    def test_the_gap_closes_on_the_validation_run(self):
        shrink = self.document["shrink"]
        self.assertGreater(shrink["closed"], 0.85)
        low, high = shrink["closed_interval"]
        self.assertLess(low, shrink["closed"])
        self.assertGreater(high, shrink["closed"])
        self.assertGreater(shrink["before"], 1.5)
        told = [*shrink["channels"], shrink["force_error_N"]]
        for row in told:
            low, high = row["after_interval"]
            self.assertLess(low, row["after"])
            self.assertGreater(high, row["after"])

    def test_shares_of_each_budget_add_up(self):
        for name in ("channels", "phases", "bands", "blocks"):
            shares = [row["share"] for row in self.document["where"][name]]
            with self.subTest(budget=name):
                # A block test within its threshold has no part in the gap.
                is_nobody = name == "blocks" and all(self.acquitted())
                total = 0.0 if is_nobody else 1.0
                self.assertAlmostEqual(sum(shares), total, places=6)

    def acquitted(self):
        return [r["acquitted"] for r in self.document["where"]["blocks"]]

    def test_the_controller_which_is_exact_is_acquitted(self):
        rows = {r["block"]: r for r in self.document["where"]["blocks"]}
        self.assertTrue(rows["controller"]["acquitted"])
        # Relaxation is one of the contact: that is where most is left.
        worst = max(rows.values(), key=lambda r: r["normalised_rms"])
        self.assertEqual(worst["block"], "contact")

    def test_the_report_shows_the_verdict(self):
        page = (self.out / "report.html").read_text()
        self.assertIn(find_effect("relaxation").title, page)


class TestFit(unittest.TestCase):
    def test_a_fit_needs_no_more_than_the_recording(self):
        with tempfile.TemporaryDirectory() as folder:
            code = main(["fit", str(EXAMPLE), "--out", folder])
            document = json.loads((Path(folder) / "fit.json").read_text())
        self.assertEqual(code, 0)
        self.assertEqual(len(document["parameters"]), 6)
        correlation = np.array(document["correlation"])
        np.testing.assert_allclose(np.diag(correlation), 1.0)
        # The network's stiffness is a start within a fifth of the truth.
        starts = {s["run"]: s for s in document["contact_starts"]}
        truth = TRUTH["contact_stiffness_N_m"]
        self.assertAlmostEqual(
            starts["push"]["stiffness"] / (truth + ARM), 1.0, delta=0.4
        )


class TestRealDrive(unittest.TestCase):
    @needs_shared("real/emps")
    def test_the_published_friction_of_a_real_drive_is_found(self):
        campaign = LoadCampaign(SHARED / "real" / "emps")
        document = MakeDocument(diagnose(campaign))
        self.assertEqual(document["verdict"]["effects"], ["coulomb_friction"])
        subject = {
            p["name"]: p["value"] for p in document["subject"]["parameters"]
        }
        (coulomb,) = document["causes"][0]["parameters"]
        published = (
            (subject["mass_kg"], 95.11),
            (subject["viscous_N_s_m"], 203.5),
            (coulomb["value"], 20.39),
        )
        for found, expected in published:
            self.assertAlmostEqual(found / expected, 1.0, delta=0.03)
        force = document["shrink"]["force_error_N"]
        self.assertLess(force["after"] / force["signal"], 0.065)
        self.assertGreater(force["before"] / force["signal"], 0.10)


if __name__ == "__main__":
    unittest.main()
