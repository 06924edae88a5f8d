"""Preparing runs: channels that were not recorded have no weight."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.campaign import LoadCampaign
from brace_drake.gap.devices import MakeDevice
from brace_drake.gap.prepare import estimate_floors, prepare_runs
from tests.shared_data import EXAMPLE


class TestMissing(unittest.TestCase):
    def test_a_marker_that_was_not_recorded_weighs_nothing(self):
        campaign = LoadCampaign(EXAMPLE)
        twin = MakeDevice(campaign).twin
        subject = np.array([p.nominal for p in twin.subject])
        floors, _ = estimate_floors(twin, campaign, subject, 0)
        run = next(r for r in campaign.runs if r.contact)
        kept = {
            name: values
            for name, values in run.channels.items()
            if not name.startswith("torso")
        }
        runs = run, replace(run, channels=kept)
        whole, part = prepare_runs(twin, runs, floors, campaign.rate_hz, 0)
        torso = np.char.startswith(np.array(twin.channels), "torso")
        self.assertTrue(np.all(whole.used))
        np.testing.assert_array_equal(part.used, ~torso)
        np.testing.assert_array_equal(
            part.weights[:, ~torso], whole.weights[:, ~torso]
        )


if __name__ == "__main__":
    unittest.main()
