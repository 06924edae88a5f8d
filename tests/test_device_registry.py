"""A device of another package: one file, from campaign to verdict."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices import register_device
from brace_drake.devices.registry import forget_device
from brace_drake.diagnosis import diagnose
from brace_drake.recording import CheckCampaign, LoadCampaign
from brace_drake.scenario.load import LoadScenario, SaveScenario
from brace_drake.validation.repaired import MakeRepairedScenario
from tests.foreign.oven import CARD
from tests.oven_recordings import LAG_S, LATE_S, write_oven


class TestRegistry(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        register_device(CARD)
        cls.addClassCleanup(forget_device, CARD.name)
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.path = write_oven(Path(folder.name) / "oven")

    def test_its_campaigns_are_checked_by_its_channels(self):
        self.assertEqual(CheckCampaign(self.path), [])

    def test_its_sensor_that_lags_is_named(self):
        found = diagnose(LoadCampaign(self.path))
        self.assertEqual(found.verdict.effects, ("sensor_lag",))
        ((_, values),) = found.verdict.winner.uses
        np.testing.assert_allclose(values, [LATE_S], rtol=0.05)
        subject = found.verdict.winner.subject
        np.testing.assert_allclose(subject, [LAG_S, 0.6], rtol=0.02)

        repaired = MakeRepairedScenario(found.device.twin, found.verdict.winner)
        with tempfile.TemporaryDirectory() as folder:
            SaveScenario(repaired, Path(folder) / "a.yaml")
            loaded = LoadScenario(Path(folder) / "a.yaml")
        again = diagnose(LoadCampaign(self.path), scenario=loaded)
        self.assertFalse(again.verdict.gap)

    def test_a_device_is_registered_once(self):
        with self.assertRaisesRegex(CampaignError, "'oven' is registered"):
            register_device(CARD)


if __name__ == "__main__":
    unittest.main()
