"""Motions of a drive and of a pad that stay within what was recorded."""

import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.devices.motions.limits import leg_motions, pad_motions
from brace_drake.devices.motions.recorded_reach import (
    Reach,
    largest_speed,
    recorded_reach,
    ways_within,
)
from brace_drake.devices.pad_bench.twin import PadBenchTwin
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.leg_bench import MakeLegBenchScenario
from brace_drake.scenario.pad_bench import MakePadBenchScenario
from tests.pad_recordings import make_campaign, relaxing

NAMES = [
    "hold",
    "slow_cycle",
    "stairs",
    "reversal",
    "reversal_slow",
    "reversal_small",
    "multisine",
]


def moved(way, rate=100.0):
    time = np.arange(len(way)) / rate
    channels = {"time_s": time, "way_m": way, "force_N": -3.0 * way}
    return Run("r.csv", True, "press", None, "fit", channels)


class TestReach(unittest.TestCase):
    def test_it_is_that_of_all_runs(self):
        ramp = np.clip(np.linspace(-0.5, 1.5, 401), 0.0, 1.0)
        runs = [moved(2e-3 + 8e-3 * ramp), moved(2e-3 - 4e-3 * ramp[:301])]
        reach = recorded_reach(runs, "way_m", "force_N")
        self.assertAlmostEqual(reach.start, 2e-3)
        self.assertAlmostEqual(reach.low, -2e-3)
        self.assertAlmostEqual(reach.high, 10e-3)
        # 8 mm in half of four seconds.
        self.assertAlmostEqual(reach.speed, 4e-3)
        self.assertAlmostEqual(reach.force, 30e-3)
        self.assertAlmostEqual(reach.duration, 4.0)

    def test_ways_go_no_further_and_no_faster(self):
        reaches = (
            Reach(0.0, 0.0, 12e-3, 30e-3, 50.0, 20.0),
            # Slow for its length, and from the middle.
            Reach(0.1, -0.2, 0.3, 0.02, 50.0, 20.0),
            # From one end down, at a rate of samples that is low for it.
            Reach(5e-3, -5e-3, 5e-3, 0.4, 50.0, 3.0),
            # So slow that a minute reaches a part of the range.
            Reach(0.0, 0.0, 12e-3, 2e-4, 50.0, 60.0),
            Reach(-0.1, -0.1, 0.1, 0.02, 50.0, 20.0),
        )
        for reach in reaches:
            ways = ways_within(reach, 100.0)
            self.assertEqual([w.name for w in ways], NAMES)
            for way in ways:
                with self.subTest(way=way.name, reach=reach):
                    y = way.position
                    self.assertAlmostEqual(y[0], reach.start)
                    self.assertGreaterEqual(y.min(), reach.low)
                    self.assertLessEqual(y.max(), reach.high)
                    speed = np.abs(np.diff(y) / np.diff(way.time)).max()
                    self.assertLessEqual(speed, reach.speed)
                    # And they are worth recording.
                    self.assertGreater(speed, 0.02 * reach.speed)
                    self.assertGreaterEqual(way.time[-1] + 0.02, reach.duration)

    def test_noise_of_readings_is_no_speed(self):
        time = np.arange(6000) / 100.0
        noise = 5e-6 * np.random.default_rng(0).standard_normal(6000)
        speed = largest_speed(time, 2e-4 * time + noise)
        self.assertLess(speed, 2.3e-4)
        # A fast press among noise is found all the same.
        press = 5e-3 * np.clip((time - 20.0) / 0.5, 0.0, 1.0)
        self.assertAlmostEqual(
            largest_speed(time, press + noise), 1e-2, delta=1e-3
        )

    def test_one_wrong_sample_reaches_nowhere(self):
        way = 1e-3 * np.sin(np.arange(400) / 20.0)
        way[100] = 0.2
        reach = recorded_reach([moved(way)], "way_m", "force_N")
        self.assertLess(reach.high, 1.01e-3)
        self.assertLess(reach.force, 3.03e-3)

    def test_nothing_that_moved_leads_to_no_motion(self):
        self.assertEqual(ways_within(Reach(0, 0, 0, 0, 1, 9), 100.0), [])


class TestPad(unittest.TestCase):
    def setUp(self):
        self.campaign = make_campaign(relaxing)
        self.twin = PadBenchTwin(MakePadBenchScenario(self.campaign))
        self.runs = self.campaign.split("fit")

    def test_a_stiffer_specimen_passes_the_recorded_force(self):
        known = pad_motions(self.twin, self.runs, self.campaign.rate_hz)
        (hold,) = [m for m in known.motions if m.name == "hold"]
        subject = np.array([p.nominal for p in self.twin.subject])
        told = []
        for stiffness in (1500.0, 6000.0):
            subject[0] = stiffness
            log = self.twin.simulate(self.twin.motion(hold.run), subject)
            told.append(known.exceeded(self.twin, hold, subject, log))
        self.assertIsNone(told[0])
        self.assertRegex(told[1], "a force of .* N, recorded .* N")


class TestDrive(unittest.TestCase):
    """A drive that lags, and holds a load."""

    SUBJECT = np.array([95.0, 200.0, 4.0])

    def setUp(self):
        time = np.arange(4000) / 1000.0
        desired = 0.05 * (1.0 - np.cos(np.pi * time))
        still = {"position_m": 0.0 * time, "force_command_N": 0.0 * time + 4.0}
        channels = {"time_s": time, "position_desired_m": desired, **still}
        asked = Run("t.csv", False, "tracking", None, "fit", channels)
        campaign = Campaign(
            Path("drive"), "leg bench", 1000.0, "d", (asked,),
            {"mass_kg": 95.0, "viscous_N_s_m": 200.0},
            control={"kp_1_s": 20.0, "kv_N_s_m": 3000.0},
        )  # fmt: skip
        self.twin = LegBenchTwin(MakeLegBenchScenario(campaign))
        log = self.twin.simulate(self.twin.motion(asked), self.SUBJECT)
        moved = {"force_command_N": log[:, 0], "position_m": log[:, 1]}
        self.recorded = replace(asked, channels={**channels, **moved})
        self.known = leg_motions(self.twin, [self.recorded], 1000.0)

    def log_of(self, motion):
        return self.twin.simulate(self.twin.motion(motion.run), self.SUBJECT)

    def test_it_stands_at_first_and_follows(self):
        for motion in self.known.motions:
            log = self.log_of(motion)
            y_d = motion.run.channels["position_desired_m"]
            with self.subTest(motion=motion.name):
                if motion.name == "hold":
                    # But for what it sags under its load.
                    np.testing.assert_allclose(log[:200, 1], y_d[0], atol=2e-4)
                # With kp = 20 /s the position lags by about 1 / kp.
                lag = np.abs(np.gradient(y_d, 1e-3)).max() / 20.0
                away = np.abs(log[: len(y_d), 1] - y_d[: len(log)]).max()
                self.assertLess(away, 1.5 * lag + 2e-4)

    def test_what_is_like_the_recording_is_safe_and_what_is_harder_is_not(self):
        safe = {
            m.name: self.known.exceeded(self.twin, m, None, self.log_of(m))
            for m in self.known.motions
        }
        harder = [name for name, why in safe.items() if why is not None]
        # Short steps, and the full speed at five times the rate.
        self.assertEqual(harder, ["stairs", "reversal_small"])
        for name in harder:
            self.assertIn("a force of", safe[name])

    def test_a_position_or_a_force_beyond_is_told(self):
        known = self.known
        motion, log = known.motions[0], np.zeros((400, 2))
        log[:, 1] = 0.05
        self.assertIsNone(known.exceeded(self.twin, motion, None, log))
        log[200:, 1] = 0.12
        text = known.exceeded(self.twin, motion, None, log)
        self.assertIn("50.0 to 120.0 mm", text)
        log[:, 1] = 0.05 + 0.03 * np.clip(np.arange(-2, 2, 0.01), 0.0, 1.0)
        text = known.exceeded(self.twin, motion, None, log)
        self.assertRegex(text, r"0\.3 m/s, recorded 0\.1\d+ m/s")
        log[:, 1], log[2, 0] = 0.05, -1e4
        text = known.exceeded(self.twin, motion, None, log)
        self.assertIn("a force of 1e+04 N", text)

    def test_a_drive_at_its_limit_is_not_safe(self):
        twin = self.twin
        twin.numbers.control[2] = 30.0
        known = leg_motions(twin, [self.recorded], 1000.0)
        log = np.zeros((400, 2))
        log[:, 1] = 0.05
        self.assertIsNone(known.exceeded(twin, None, None, log))
        log[2, 0] = 30.0
        self.assertIn("a force", known.exceeded(twin, None, None, log))

    def test_runs_in_the_air_say_nothing_of_presses(self):
        far = {k: 3.0 * v for k, v in self.recorded.channels.items()}
        far["time_s"] = self.recorded.time_s
        runs = [
            replace(self.recorded, channels=far),
            replace(self.recorded, contact=True),
        ]
        known = leg_motions(self.twin, runs, 1000.0)
        for motion in known.motions:
            self.assertTrue(motion.contact)
            reached = motion.run.channels["position_desired_m"].max()
            self.assertLess(reached, 0.1)

    def test_without_a_position_control_no_motion_is_safe(self):
        channels = dict(self.recorded.channels)
        del channels["position_desired_m"]
        run = replace(self.recorded, channels=channels)
        self.assertIsNone(leg_motions(self.twin, [run], 1000.0))


if __name__ == "__main__":
    unittest.main()
