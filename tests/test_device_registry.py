"""A device of another package: one file, from campaign to verdict."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices import register_device
from brace_drake.devices.registry import forget_device
from brace_drake.diagnosis import diagnose
from brace_drake.recording import (
    Campaign,
    CheckCampaign,
    LoadCampaign,
    Run,
    WriteCampaign,
)
from brace_drake.scenario.load import LoadScenario, SaveScenario
from brace_drake.validation.repaired import MakeRepairedScenario
from tests.foreign.oven import CARD, HEATER, READING

RATE, LAG_S, LATE_S = 20.0, 2.5, 0.3


def heated(seed: int) -> dict[str, np.ndarray]:
    """An oven that is heated in steps, its thermometer late by a lag; Euler's
    method at a thousandth of a second.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(400) / RATE
    heat = 100.0 * (rng.random(20) > 0.5)[(t / 1.0).astype(int)]
    fine = 50
    temperature, read, rows = 0.0, 0.0, []
    for u in heat:
        rows.append(read)
        for _ in range(fine):
            temperature += (0.6 * u - temperature) / LAG_S / RATE / fine
            read += (temperature - read) / LATE_S / RATE / fine
    noise = 0.02 * rng.standard_normal(len(t))
    return {"time_s": t, HEATER: heat, READING: np.array(rows) + noise}


class TestRegistry(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        register_device(CARD)
        cls.addClassCleanup(forget_device, CARD.name)
        runs = [
            Run(f"r{i}.csv", True, "steps", None, split, heated(i))
            for i, split in enumerate(["fit", "fit", "validation"])
        ]
        campaign = Campaign(Path("o"), "oven", RATE, "oven", tuple(runs))
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.path = Path(folder.name) / "oven"
        WriteCampaign(campaign, cls.path)

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
