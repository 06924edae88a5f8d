"""A campaign may name its scenario; what was used is told, with its hash."""

import hashlib
import json
import shutil
import tempfile
import unittest
from pathlib import Path

import yaml

from brace_drake.core.errors import CampaignError, ScenarioError
from brace_drake.devices import register_device
from brace_drake.devices.device import MakeDevice
from brace_drake.devices.nominal_scenario import choose_scenario
from brace_drake.devices.registry import forget_device
from brace_drake.recording import CheckCampaign, LoadCampaign, WriteCampaign
from brace_drake.recording.importing.mcap_file import (
    LoadMcapCampaign,
    WriteMcap,
)
from brace_drake.scenario.load import LoadScenario
from tests.commands import run_command
from tests.foreign.oven import CARD
from tests.oven_recordings import write_oven

OWN = "device: oven\nlag: 2.2\n"
HELD = OWN + "estimation:\n  fixed: {resistance_K_W: 0.6}\n"


class TestNamedScenario(unittest.TestCase):
    def setUp(self):
        register_device(CARD)
        self.addCleanup(forget_device, CARD.name)
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.path = write_oven(self.folder / "oven", late=0.0)

    def name(self, file="own.yaml", text=OWN):
        """The campaign with a scenario of that path."""
        if text is not None:
            (self.path / file).write_text(text)
        manifest = self.path / "campaign.yaml"
        content = yaml.safe_load(manifest.read_text())
        content["scenario"] = file
        manifest.write_text(yaml.safe_dump(content))

    def lag(self, scenario=None):
        """Of the nominal twin."""
        twin = MakeDevice(LoadCampaign(self.path), scenario).twin
        return twin.scenario.lag

    def test_without_a_word_it_is_the_packages(self):
        found = choose_scenario(LoadCampaign(self.path))
        self.assertIsNone(found.scenario)
        self.assertEqual(found.named_by, "package")
        self.assertEqual(self.lag(), 2.0)

    def test_what_the_campaign_names_is_its_twins(self):
        self.name()
        self.assertEqual(self.lag(), 2.2)
        found = choose_scenario(LoadCampaign(self.path))
        self.assertEqual(
            (found.file, found.named_by), ("own.yaml", "campaign.yaml")
        )
        digest = hashlib.sha256(OWN.encode()).hexdigest()
        self.assertEqual(found.describe(found.scenario)["sha256"], digest)

    def test_a_path_beside_the_folder_is_relative_to_it(self):
        self.name("../shared.yaml")
        self.assertEqual(self.lag(), 2.2)

    def test_a_callers_file_wins(self):
        self.name()
        other = self.folder / "other.yaml"
        other.write_text("device: oven\nlag: 3.0\n")
        self.assertEqual(self.lag(other), 3.0)
        self.assertEqual(self.lag(LoadScenario(other)), 3.0)

    def test_what_cannot_be_read_is_an_error_of_the_campaign(self):
        (self.path / "a_folder").mkdir()
        for file, words in (
            ("nowhere.yaml", "scenario: nowhere.yaml cannot be read: No such"),
            ("a_folder", "is a folder"),
            ("/etc/hostname", "relative to the campaign's folder"),
            ("../../../../etc/hostname", "nor beside it"),
            (3, "relative to the campaign's folder"),
        ):
            with self.subTest(file=file):
                self.name(file, text=None)
                with self.assertRaisesRegex(CampaignError, words):
                    LoadCampaign(self.path)
                (problem,) = CheckCampaign(self.path)
                self.assertEqual(problem.severity, "error")

    def test_what_is_no_scenario_is_told_with_its_file(self):
        for text, words in (
            ("device: oven\nlagg: 3\n", "own.yaml: lagg: no such key, did you"),
            ("device: pad bench\n", "but the scenario is of 'pad bench'"),
            (OWN + "estimation: 3\n", "own.yaml: estimation is 3"),
        ):
            with self.subTest(text=text):
                self.name(text=text)
                for command in ("check", "fit"):
                    status, _, errors = run_command(command, self.path)
                    self.assertEqual((status, errors.count("\n")), (2, 1))
                    self.assertIn(words, errors)

    def test_commands_say_which_was_used(self):
        self.name()
        _, said, _ = run_command("check", self.path)
        self.assertIn("scenario: own.yaml, named by campaign.yaml", said)
        other = self.folder / "other.yaml"
        other.write_text("device: oven\nlag: 3.0\n")
        _, said, _ = run_command("check", self.path, "--scenario", other)
        self.assertIn("by --scenario, not own.yaml of campaign.yaml", said)

    def test_a_fit_tells_file_and_hash_and_holds_what_the_file_holds(self):
        self.name(text=HELD)
        out = self.folder / "out"
        status, said, errors = run_command("fit", self.path, "--out", out)
        self.assertEqual(status, 0, errors)
        self.assertIn("scenario: own.yaml, named by campaign.yaml", said)
        found = json.loads((out / "fit.json").read_text())
        digest = hashlib.sha256(HELD.encode()).hexdigest()
        self.assertEqual(found["scenario"]["sha256"], digest)
        rows = {p["name"]: p for p in found["parameters"]}
        self.assertEqual(rows["lag_s"]["nominal"], 2.2)
        self.assertEqual(rows["resistance_K_W"]["value"], 0.6)
        self.assertTrue(rows["resistance_K_W"]["fixed"])
        status, _, _ = run_command(
            "fit", self.path, "--bounds", "resistance_K_W=0.1:0.5", "--out", out
        )
        self.assertEqual(status, 0)
        found = json.loads((out / "fit.json").read_text())
        rows = {p["name"]: p for p in found["parameters"]}
        self.assertTrue(rows["resistance_K_W"]["at_limit"])

    def test_a_copy_of_the_campaign_keeps_it(self):
        self.name("../shared.yaml")
        campaign = LoadCampaign(self.path)
        copy = self.folder / "copies" / "copy"
        WriteCampaign(campaign, copy)
        (self.folder / "shared.yaml").unlink()
        self.assertEqual((copy / "shared.yaml").read_text(), OWN)
        again = MakeDevice(LoadCampaign(copy)).twin.scenario
        self.assertEqual(again.lag, 2.2)

    def test_a_campaign_in_one_file_keeps_it(self):
        self.name()
        file = self.folder / "a.mcap"
        try:
            WriteMcap(LoadCampaign(self.path), file)
        except CampaignError as error:
            self.skipTest(str(error))
        shutil.rmtree(self.path)
        WriteCampaign(LoadMcapCampaign(file), self.path)
        self.assertEqual(self.lag(), 2.2)

    def test_an_import_takes_the_scenario_that_its_map_names(self):
        (self.folder / "own.yaml").write_text(OWN)
        map_file = self.folder / "oven.map.yaml"
        head = (
            "format: brace-import/1\ndevice: oven\nscenario: own.yaml\n"
            "columns: {time_s: time_s, heater_W: heater_W,"
            " temperature_K: temperature_K}\n"
            "runs: [{file: oven/r0.csv, split: fit}]\n"
        )
        map_file.write_text(head)
        out = self.folder / "imported"
        status, _, errors = run_command("import", map_file, "--out", out)
        self.assertEqual(status, 0, errors)
        self.assertEqual((out / "own.yaml").read_text(), OWN)
        twin = MakeDevice(LoadCampaign(out)).twin
        self.assertEqual(twin.scenario.lag, 2.2)
        map_file.write_text(head.replace("own.yaml", "none.yaml"))
        other = self.folder / "other"
        status, _, errors = run_command("import", map_file, "--out", other)
        self.assertEqual((status, errors.count("\n")), (2, 1))
        self.assertIn("scenario: none.yaml: cannot be read", errors)

    def test_a_block_that_fits_is_no_part_of_the_machine(self):
        self.name(text=HELD)
        self.assertEqual(self.lag(), 2.2)
        with self.assertRaisesRegex(ScenarioError, "estimatoin: no such key"):
            self.name(text=HELD.replace("estimation", "estimatoin"))
            self.lag()


if __name__ == "__main__":
    unittest.main()
