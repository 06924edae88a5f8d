"""Verdicts on recordings of a pad that the twin has not made."""

import json
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.cli.main import main
from brace_drake.core.errors import BraceError
from brace_drake.design.next_run import WriteNextRun, choose_next_run
from brace_drake.diagnosis import diagnose
from brace_drake.effects.registry import find_effect
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.held_out import check_fit
from brace_drake.recording.write import WriteCampaign
from tests.pad_recordings import (
    ARM,
    SUBJECT,
    linear,
    make_campaign,
    relaxing,
    standard_linear_solid,
    stiffening,
)


class TestDiagnosis(unittest.TestCase):
    def diagnose(self, force_of, **changes):
        """The document that the command leaves for a campaign."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "campaign"
            WriteCampaign(make_campaign(force_of, **changes), path)
            out = Path(folder) / "out"
            self.assertEqual(
                main(["diagnose", str(path), "--out", str(out)]), 0
            )
            return json.loads((out / "diagnosis.json").read_text())

    def test_a_linear_contact_has_no_gap(self):
        document = self.diagnose(linear)
        self.assertFalse(document["verdict"]["gap"])
        self.assertEqual(document["verdict"]["effects"], [])

    def test_relaxation_is_named_and_measured(self):
        document = self.diagnose(relaxing)
        verdict = document["verdict"]
        self.assertEqual(verdict["effects"], ["relaxation"])
        self.assertEqual(verdict["blocks"], ["contact"])
        values = [p["value"] for p in document["causes"][0]["parameters"]]
        np.testing.assert_allclose(values, list(ARM.values()), rtol=5e-3)
        self.assertGreater(document["shrink"]["closed"], 0.98)
        accused = [
            row["block"]
            for row in document["where"]["blocks"]
            if not row["acquitted"]
        ]
        self.assertEqual(accused, ["contact"])

    def test_a_repair_that_breaks_down_on_new_runs_keeps_the_verdict(self):
        with mock.patch(
            "brace_drake.validation.shrinkage.repair_runs",
            side_effect=BraceError("the twin breaks down"),
        ):
            document = self.diagnose(relaxing)
        self.assertEqual(document["verdict"]["effects"], ["relaxation"])
        self.assertIsNone(document["shrink"]["closed"])
        self.assertIsNone(document["verdict"]["confirmed"])
        warnings = " ".join(document["warnings"])
        self.assertIn("breaks down on the validation runs", warnings)

    def test_hardening_and_relaxation_together_are_both_named(self):
        def both(motion, time):
            return relaxing(motion, time) + (
                stiffening(motion, time) - linear(motion, time)
            )

        document = self.diagnose(both)
        effects = sorted(document["verdict"]["effects"])
        self.assertEqual(effects, ["hardening", "relaxation"])
        found = {row["effect"]: row["validation"] for row in document["causes"]}
        name = document["causes"][0]["effect"]
        pair, shrink = found.pop(name), document["shrink"]
        self.assertAlmostEqual(pair["gap"], shrink["after"], places=9)
        # What is there predicts new runs to the noise, half of it does not.
        self.assertLess(pair["lower95"], 1.02)
        self.assertGreater(pair["upper95"], 0.98)
        for name in effects:
            self.assertGreater(found[name]["lower95"], pair["upper95"])
            self.assertLess(found[name]["gap"], shrink["before"])

    def test_a_biased_sensor_shows_off_the_tissue(self):
        document = self.diagnose(lambda m, t: linear(m, t) + 0.3)
        self.assertEqual(document["verdict"]["effects"], ["force_bias"])
        self.assertEqual(document["verdict"]["blocks"], ["sensing"])

    def test_what_is_tied_is_set_apart_by_a_press_within_the_recorded(self):
        def slowly_relaxing(motion, time):
            return standard_linear_solid(
                motion, time, **SUBJECT, arm=24.0, tau=3.0
            )

        campaign = make_campaign(slowly_relaxing, force_noise=0.05)
        found = diagnose(campaign)
        self.assertEqual(found.verdict.effects, ("relaxation",))
        rival = find_effect("hysteresis")
        tied = fit_effects(found.evaluator, [rival], rival.starts()[:1])
        tied = check_fit(found.evaluator, tied)
        chosen = choose_next_run(
            found.device,
            found.evaluator,
            found.criterion,
            [*found.fits, tied],
            replace(found.verdict, ambiguous_with=("hysteresis",)),
            0,
        )
        (pair,) = chosen.pairs
        names = {pair.first, pair.second}
        self.assertEqual(names, {"relaxation", "hysteresis"})
        self.assertGreater(np.sqrt(pair.separation), 3.0)
        with tempfile.TemporaryDirectory() as folder:
            path = WriteNextRun(chosen, Path(folder))
            names = path.read_text().splitlines()[0].split(",")
            table = np.loadtxt(path, delimiter=",", skiprows=1)
        self.assertEqual(names, ["time_s", "displacement_m", "contact"])
        pressed = [run.channels["displacement_m"] for run in campaign.runs]
        self.assertLess(table[:, 1].max(), max(y.max() for y in pressed))
        self.assertGreater(table[:, 1].min(), min(y.min() for y in pressed))


if __name__ == "__main__":
    unittest.main()
