"""Parameters that the runs tell, and those that they say nothing of."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.cli.diagnosis.fit import format_fit
from brace_drake.devices.device import MakeDevice
from brace_drake.identification.subject.campaign_fit import fit_campaign
from brace_drake.recording import LoadCampaign
from tests.shared_data import EXAMPLE


def without_contact():
    """The example's campaign, of which only free runs were recorded."""
    campaign = LoadCampaign(EXAMPLE)
    free = tuple(r for r in campaign.runs if not r.contact)
    return replace(campaign, runs=free)


class TestUnseen(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        campaign = without_contact()
        subject = MakeDevice(campaign).twin.subject
        cls.limits = {p.name: (p.lower, p.upper) for p in subject}
        cls.found = fit_campaign(campaign, 1, 0)

    def test_what_free_runs_do_not_touch_has_no_standard_error(self):
        for row in self.found["parameters"]:
            with self.subTest(parameter=row["name"]):
                self.assertIsNone(row["standard_error"])
                self.assertEqual(row["value"], row["nominal"])
                limits = self.limits[row["name"]]
                self.assertEqual((row["lower95"], row["upper95"]), limits)
        self.assertIsNone(self.found["condition_number"])
        np.testing.assert_array_equal(self.found["correlation"], np.eye(6))

    def test_the_table_says_so(self):
        table = format_fit(self.found)
        self.assertEqual(table.count(" unknown "), 6)
        self.assertIn("condition unknown", table)


if __name__ == "__main__":
    unittest.main()
