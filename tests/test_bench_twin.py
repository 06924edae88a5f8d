"""The nominal twin against a recording made by an independent simulator."""

import unittest

import numpy as np

from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.identification.noise_floor import is_on_grid
from brace_drake.identification.prepare import estimate_floors
from brace_drake.recording import LoadCampaign
from brace_drake.scenario.brace import BenchScenario
from tests.shared_data import SHARED, needs_shared


class TestNominalRecording(unittest.TestCase):
    @needs_shared("campaigns/open00_nominal")
    def test_every_run_and_channel_is_reproduced_to_the_floor(self):
        campaign = LoadCampaign(SHARED / "campaigns" / "open00_nominal")
        twin = BenchTwin(BenchScenario(), 5e-4)
        subject = np.array([p.nominal for p in twin.subject])
        fine = BenchTwin(BenchScenario(), 1e-4)
        floors, _ = estimate_floors(fine, campaign, subject, seed=3)
        for run in campaign.runs:
            simulated = BenchTwin(BenchScenario(), 2e-4).simulate(
                twin.motion(run), subject
            )
            residual = twin.measured(run) - simulated
            rms = np.sqrt(np.mean(residual**2, axis=0))
            ratio = (rms / floors[run.contact].rms)[twin.active(run)]
            # 1.05 is the bar; a virtual position that hardly moves is
            # rounded to a micrometre, its own noise.
            quiet = np.ptp(run.channels["ring2_y_virtual_m"]) < 2e-5
            ratio = ratio[:-1] if quiet else ratio
            with self.subTest(run=run.name):
                self.assertLess(ratio.max(), 1.09)
                self.assertLess(np.sqrt(np.mean(ratio**2)), 1.02)

    def test_a_reading_of_a_resting_twin_lies_on_its_resolution(self):
        twin = BenchTwin(BenchScenario())
        from brace_drake.devices.bench.rollout import Motion

        motion = Motion(np.zeros((201, 3)), True)
        subject = np.array([p.nominal for p in twin.subject])
        log = twin.simulate(motion, subject, (), np.random.default_rng(1))
        self.assertTrue(is_on_grid(log[:, 6], 1e-5))

    def test_a_resting_twin_without_noise_stays_at_rest(self):
        twin = BenchTwin(BenchScenario())
        from brace_drake.devices.bench.rollout import Motion

        motion = Motion(np.zeros((1001, 3)), True)
        subject = np.array([p.nominal for p in twin.subject])
        log = twin.simulate(motion, subject)
        # Gravity is fed forward exactly, the pads' preload cancels.
        self.assertLess(np.ptp(log[:, 6:12]), 1e-4)
        self.assertLess(np.abs(log[:, 12:18]).max(), 1e-9)


if __name__ == "__main__":
    unittest.main()
