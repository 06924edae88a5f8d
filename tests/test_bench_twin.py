"""The nominal twin against a recording made by an independent simulator."""

import unittest

import numpy as np

from brace_drake.devices.bench.rollout import Motion
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

    def test_rounding_is_noise_of_its_variance(self):
        log = self.noisy(BenchScenario())
        length, force = log[:, 6:12], log[:, 12:15]
        for name, readings, sigma, step in (
            ("length", length, 5e-6, 1e-5),
            ("force", force, 0.03, 0.0244140625),
        ):
            with self.subTest(name):
                self.assertFalse(is_on_grid(readings[:, 0], step))
                expected = np.hypot(sigma, step / np.sqrt(12.0))
                # Chance alone: 201 samples of a few channels.
                self.assertAlmostEqual(
                    np.diff(readings, axis=0).std() / np.sqrt(2.0) / expected,
                    1.0,
                    delta=0.1,
                )

    def test_readings_of_less_noise_than_half_a_step_stay_rounded(self):
        scenario = BenchScenario()
        scenario.sensors.leg_length_noise = 2e-6
        log = self.noisy(scenario)
        self.assertTrue(is_on_grid(log[:, 6], 1e-5))
        self.assertFalse(is_on_grid(log[:, 13], 0.0244140625))

    def test_a_small_change_moves_noisy_replays_as_it_moves_exact_ones(self):
        twin = BenchTwin(BenchScenario())
        motion = Motion(
            0.002
            * np.sin(np.arange(801) / 80.0)[:, None]
            * np.array([-1.0, 0.0, 0.0]),
            True,
        )
        subject = np.array([p.nominal for p in twin.subject])
        near = subject * np.where(np.arange(len(subject)) == 0, 1.0001, 1.0)
        change = [
            twin.simulate(motion, near, (), draw())
            - twin.simulate(motion, subject, (), draw())
            for draw in (lambda: None, lambda: np.random.default_rng(4))
        ]
        exact, noisy = (c[:, 13] for c in change)
        error = np.linalg.norm(noisy - exact)
        self.assertLess(error, 0.05 * np.linalg.norm(exact))

    def noisy(self, scenario):
        """Log of a bench that is held free, with noise in its readings."""
        twin = BenchTwin(scenario)
        motion = Motion(np.zeros((201, 3)), False)
        subject = np.array([p.nominal for p in twin.subject])
        return twin.simulate(motion, subject, (), np.random.default_rng(1))

    def test_a_resting_twin_without_noise_stays_at_rest(self):
        twin = BenchTwin(BenchScenario())
        motion = Motion(np.zeros((1001, 3)), True)
        subject = np.array([p.nominal for p in twin.subject])
        log = twin.simulate(motion, subject)
        # Gravity is fed forward exactly, the pads' preload cancels.
        self.assertLess(np.ptp(log[:, 6:12]), 1e-4)
        self.assertLess(np.abs(log[:, 12:18]).max(), 1e-9)


if __name__ == "__main__":
    unittest.main()
