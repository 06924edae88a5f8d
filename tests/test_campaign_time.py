"""A run may begin at any time of a clock, and lasts no more than a day."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.recording import CheckCampaign, LoadCampaign, WriteCampaign
from brace_drake.recording.samples import (
    LONGEST_S,
    check_time,
    since_first_row,
)
from tests.axis_recordings import make_campaign as make_axis
from tests.test_campaign_read import (
    RATE_HZ,
    CampaignFolderTest,
    make_campaign,
    make_leg_bench,
    make_pad_bench,
)

# Seconds since 1970, those of a clock that counts down, and small ones.
STARTS = (1.7e9, -4e9, -3.0, 12.5, 2e5)


def begun_at(campaign, start):
    """The campaign with a start, s, added to all times."""
    runs = tuple(
        replace(r, channels={**r.channels, "time_s": r.time_s + start})
        for r in campaign.runs
    )
    return replace(campaign, runs=runs)


class TestStart(CampaignFolderTest):
    def write(self, campaign, name):
        self.path = self.folder / name
        WriteCampaign(campaign, self.path)
        return self.path

    def test_a_run_that_begins_at_any_time_is_the_run_from_zero(self):
        makers = (make_campaign, make_leg_bench, make_pad_bench)
        for maker in makers:
            campaign = maker()
            own = LoadCampaign(self.write(campaign, f"{maker.__name__}"))
            for i, start in enumerate(STARTS):
                with self.subTest(campaign.device, start=start):
                    path = self.write(
                        begun_at(campaign, start), f"{maker.__name__}{i}"
                    )
                    self.assertEqual(CheckCampaign(path), [])
                    for a, b in zip(
                        own.runs, LoadCampaign(path).runs, strict=True
                    ):
                        for name, values in a.channels.items():
                            # Of a float of this size, twice.
                            np.testing.assert_allclose(
                                b.channels[name],
                                values,
                                rtol=0,
                                atol=2 * np.spacing(abs(start)),
                            )

    def test_what_forces_say_is_asked_at_any_time(self):
        campaign = make_pad_bench()
        runs = tuple(
            replace(
                r, channels={**r.channels, "force_N": -r.channels["force_N"]}
            )
            for r in campaign.runs
        )
        flipped = begun_at(replace(campaign, runs=runs), 1.7e9)
        found = CheckCampaign(self.write(flipped, "flipped"))
        self.assertTrue(found)
        self.assertTrue(all("wrong sign" in p.message for p in found), found)

    def test_the_machine_that_is_found_does_not_depend_on_the_clock(self):
        # Force of a damper and a spring: F = 20 v + 100 y.
        axis = make_axis(lambda path, _: 20 * path[:, 1] + 100 * path[:, 0])
        for start in (0.0, 1.7e9):
            path = self.write(begun_at(axis, start), f"axis{start:g}")
            found = MakeDevice(LoadCampaign(path)).twin.scenario
            with self.subTest(start=start):
                self.assertAlmostEqual(found.viscous / 20.0, 1.0, delta=0.01)
                self.assertAlmostEqual(found.stiffness / 100.0, 1.0, delta=0.01)

    def test_milliseconds_since_1970_are_no_seconds(self):
        path = self.write(begun_at(make_pad_bench(), 1.7e12), "ms")
        for problem in CheckCampaign(path):
            self.assertEqual((problem.row, problem.column), (1, "time_s"))
            self.assertIn("1.7e+12 is outside the plausible", problem.message)
            self.assertIn("is the unit s?", problem.message)

    def test_a_start_without_a_number_moves_nothing(self):
        time = np.array([np.nan, 1.0, 2.0])
        np.testing.assert_array_equal(since_first_row(time), time)


class TestSpan(unittest.TestCase):
    def test_a_run_of_more_than_a_day_is_told_with_its_row(self):
        rate = 0.01
        time = 1.7e9 + np.arange(2000) / rate
        (problem,) = check_time(time, rate, "push.csv")
        row = int(LONGEST_S * rate) + 2
        self.assertEqual((problem.row, problem.column), (row, "time_s"))
        self.assertIn("100100 s after the first row", problem.message)
        self.assertIn("allowed: 100000 s or less", problem.message)
        self.assertEqual(check_time(time[: row - 1], rate, "push.csv"), [])

    def test_a_gap_and_a_wrong_rate_are_found_at_any_time_of_a_clock(self):
        time = 1.7e9 + np.delete(np.arange(400), range(200, 210)) / RATE_HZ
        (gap,) = check_time(time, RATE_HZ, "push.csv")
        self.assertEqual(gap.row, 201)
        found = check_time(1.7e9 + np.arange(99) / 100.0, 200.0, "push.csv")
        self.assertIn("100 Hz, but rate_hz is 200", found[0].message)


if __name__ == "__main__":
    unittest.main()
