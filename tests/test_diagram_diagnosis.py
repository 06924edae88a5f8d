"""A Drake diagram diagnosed from the command line to its report."""

import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path

from brace_drake.cli.main import main
from brace_drake.recording import WriteCampaign
from tests.foreign.campaigns import make_campaign
from tests.foreign.machines import Fault

_DIAGRAMS = Path(__file__).parent / "foreign" / "diagrams.py"
_LOAD_KG, _DISTANCE_M = 0.05, 0.4


class TestCommandLine(unittest.TestCase):
    def test_a_payload_of_other_equations_is_named_weighed_and_reported(self):
        fault = Fault("payload", 1, (_LOAD_KG, _DISTANCE_M))
        with tempfile.TemporaryDirectory() as folder:
            campaign, out = Path(folder) / "campaign", Path(folder) / "out"
            WriteCampaign(make_campaign("cart_pole", fault, 1), campaign)
            told = io.StringIO()
            with contextlib.redirect_stdout(told):
                code = main(
                    [
                        "diagnose",
                        str(campaign),
                        *("--diagram", f"{_DIAGRAMS}:MakeCartPole"),
                        *("--effects", "payload,command_gain,sensor_scale"),
                        *("--out", str(out)),
                    ]
                )
            verdict = json.loads((out / "diagnosis.json").read_text())
            report = (out / "report.html").read_text()
            is_repaired = (out / "repaired.scenario.yaml").is_file()
        self.assertEqual(code, 0)
        (row,) = verdict["verdict"]["supported"]
        self.assertEqual((row["effect"], row["form"]), ("payload", "pole"))
        load, distance = (p["value"] for p in row["parameters"])
        self.assertAlmostEqual(load / _LOAD_KG, 1.0, delta=0.05)
        self.assertAlmostEqual(distance / _DISTANCE_M, 1.0, delta=0.05)
        self.assertIn("weigh what the body carries", told.getvalue())
        self.assertIn("a mass more than nominal: pole", report)
        self.assertTrue(is_repaired)


if __name__ == "__main__":
    unittest.main()
