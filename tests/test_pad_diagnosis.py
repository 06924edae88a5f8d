"""Verdicts on recordings of a pad that the twin has not made."""

import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.campaign.write import WriteCampaign
from brace_drake.cli.main import main
from brace_drake.errors import BraceError
from tests.pad_recordings import (
    ARM,
    linear,
    make_campaign,
    relaxing,
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
            "brace_drake.gap.diagnose.repair_runs",
            side_effect=BraceError("the twin breaks down"),
        ):
            document = self.diagnose(relaxing)
        self.assertEqual(document["verdict"]["effects"], ["relaxation"])
        self.assertIsNone(document["shrink"]["closed"])
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


if __name__ == "__main__":
    unittest.main()
