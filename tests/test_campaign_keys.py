"""Keys of campaign.yaml that nobody reads, and when a campaign was recorded."""

import unittest
from unittest import mock

import yaml

from brace_drake.link.operation.recorder import Recorder, campaign_head
from brace_drake.recording import CheckCampaign, LoadCampaign, WriteCampaign
from brace_drake.recording.manifest import NOTES, parse_manifest
from brace_drake.scenario.brace import BenchScenario
from brace_drake.trend.sessions import parse_date
from tests.test_campaign_read import CampaignFolderTest, make_campaign

DATES = (
    *("2026-01-12", "2026-01-12T14:30", "2026-01-12 14:30:05"),
    "2026-01-12T14:30+01:00",
)


def told(text):
    """Problems of a manifest's own keys, as lines."""
    problems = parse_manifest(text.encode())[1]
    return [str(p) for p in problems if "no key" in p.message]


class TestUnknownKeys(unittest.TestCase):
    def test_a_key_that_nobody_reads_is_told_with_those_that_are(self):
        (line,) = told("weather: fair\nformat: brace-campaign/1\n")
        self.assertIn("warning: campaign.yaml: no key 'weather'", line)
        self.assertIn("ignored; allowed: format, device, rate_hz, runs", line)
        self.assertIn("recorded", line)

    def test_a_date_is_pointed_to_recorded(self):
        (line,) = told("date: 2026-01-12\n")
        self.assertIn("no key 'date', did you mean recorded?", line)
        # Where that is there it is no misspelling of it.
        (line,) = told("date: 2026-01-12\nrecorded: 2026-01-12\n")
        self.assertIn("no key 'date': ignored", line)

    def test_keys_of_other_devices_are_told(self):
        (line,) = told(
            "device: bench stage 2\nstages: [1, 2, 3]\n"
            "nominal: {mass_kg: 1}\ncontrol: {kp_1_s: 1}\ndiagram: {}\n"
        )
        self.assertIn("'stages', 'nominal', 'control', 'diagram': ign", line)
        for device, key in (
            ("brace", "stages: [1, 2]"),
            ("leg bench", "nominal: {mass_kg: 1, viscous_N_s_m: 1}"),
            ("leg bench", "control: {kp_1_s: 1, kv_N_s_m: 1}"),
            ("diagram", "diagram: {}"),
        ):
            with self.subTest(device, key=key):
                self.assertEqual(told(f"device: {device}\n{key}\n"), [])

    def test_a_file_of_many_runs_is_one_line(self):
        run = "{file: a.csv, contact: true, motion: push, split: fit}"
        for many, more in ((2, ""), (5000, ", and 4998 more")):
            text = "runs:\n" + f"- {run}\n" * many
            problems = parse_manifest(text.encode())[1]
            told = [p for p in problems if "duplicate" in p.message]
            self.assertEqual(
                [p.message for p in told],
                [f"duplicate file: runs 1 and 2 share it{more}"],
            )

    def test_many_unknown_keys_are_one_line(self):
        text = "".join(f"zz{i}{i}: 1\n" for i in range(200))
        (line,) = told(text)
        self.assertIn("'zz00', 'zz11'", line)
        self.assertIn("and 195 more: ignored", line)

    def test_keys_of_runs_and_numbers_are_told_with_their_place(self):
        lines = told(
            "device: leg bench\nnominal: {colour: 3}\nruns: [{pressure: 3}]\n"
        )
        self.assertIn(
            "nominal: no key 'colour': ignored; allowed: mass_kg", lines[0]
        )
        self.assertIn(
            "run 1: no key 'pressure': ignored; allowed: file", lines[1]
        )

    def test_what_a_recorder_notes_of_a_run_is_known(self):
        tally = mock.Mock(bridged=0, unanswered=0)
        tally.latencies.percentiles.return_value = [1.0, 2.0, 3.0]
        session = mock.Mock(tally=tally, trip="too far")
        recorder = mock.Mock(spec=Recorder)
        recorder.link = mock.Mock()
        noted = Recorder._DescribeLine(recorder, session)
        self.assertEqual({*noted, "complete", "begun"}, {*NOTES})
        item = {"file": "a.csv", **dict.fromkeys(NOTES, 1)}
        self.assertEqual(told(yaml.safe_dump({"runs": [item]})), [])


class TestRecorded(CampaignFolderTest):
    def setUp(self):
        super().setUp()
        WriteCampaign(make_campaign(), self.path)

    def test_every_date_that_a_trend_reads_is_read_and_written_back(self):
        for date in DATES:
            with self.subTest(date):
                self.describe(recorded=date)
                campaign = LoadCampaign(self.path)
                self.assertEqual(campaign.warnings, ())
                self.assertEqual(campaign.recorded, date)
                parse_date(campaign.recorded, "campaign.yaml")
                again = self.folder / f"again{DATES.index(date)}"
                WriteCampaign(campaign, again)
                self.assertEqual(LoadCampaign(again).recorded, date)

    def test_what_is_no_date_is_refused_with_what_is_allowed(self):
        for value in ("2026-13-45", [1, 2], "soon", 3.5, True, {"a": [1]}):
            with self.subTest(value):
                self.describe(recorded=value)
                (problem,) = CheckCampaign(self.path)
                self.assertEqual(problem.severity, "error")
                self.assertIn("recorded must be a date as in", str(problem))
                self.assertIn("2026-01-12T14:30, got", str(problem))
                self.assertNotIn("\n", str(problem))

    def test_what_a_device_tells_of_itself_is_kept_and_is_no_date(self):
        hello = mock.Mock(model="bench", identity="7", firmware="1.2")
        hello.rate_hz = 1000
        head = campaign_head(BenchScenario(), hello, 4.0)
        self.describe(recorded=head["recorded"])
        campaign = LoadCampaign(self.path)
        self.assertEqual(campaign.warnings, ())
        # A trend takes no date from it, and stumbles over none.
        self.assertEqual(campaign.recorded, "")
        WriteCampaign(campaign, self.folder / "again")
        again = LoadCampaign(self.folder / "again")
        self.assertEqual(again.recorder, head["recorded"])
        self.assertEqual(again.recorder["firmware"], "1.2")


if __name__ == "__main__":
    unittest.main()
