"""`check` tells of an axis what `fit` and `diagnose` would refuse."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.errors import BraceError, CampaignError
from brace_drake.devices.device import MakeDevice
from brace_drake.recording import CheckCampaign, LoadCampaign, WriteCampaign
from brace_drake.recording.ways import AXIS_WAYS, check_ways
from tests.axis_recordings import make_campaign
from tests.commands import run_command


def with_channels(campaign, change):
    """The campaign with each run's channels changed by a function of its place
    and its channels.
    """
    runs = tuple(
        replace(r, channels=change(i, r.channels))
        for i, r in enumerate(campaign.runs)
    )
    return replace(campaign, runs=runs)


class TestCheck(unittest.TestCase):
    def setUp(self):
        folder = self.enterContext(tempfile.TemporaryDirectory())
        self.path = Path(folder) / "axis"
        self.axis = make_campaign(lambda path, _: 20.0 * path[:, 1])

    def write(self, change):
        WriteCampaign(with_channels(self.axis, change), self.path)

    def check(self):
        code, text, error = run_command("check", self.path)
        self.assertEqual(error, "")
        return code, text.splitlines()

    def refused(self):
        """What a diagnosis says of it before it begins."""
        with self.assertRaises(BraceError) as caught:
            MakeDevice(LoadCampaign(self.path))
        return str(caught.exception)

    def test_columns_that_no_axis_has_are_an_error_of_each_run(self):
        self.write(
            lambda _, c: {
                "time_s": c["time_s"],
                "displacement_m": c["position_m"],
                "force_N": c["force_N"],
            }
        )
        code, lines = self.check()
        self.assertEqual((code, len(lines)), (2, 2))
        self.assertIn("error: short.csv: no columns to compare", lines[0])
        self.assertIn("it has time_s, displacement_m, force_N;", lines[0])
        self.assertIn("allowed: position_m and speed_command_m_s", lines[0])
        self.assertIn("(and 3 other files alike)", lines[0])
        self.assertIn("not usable, 4 errors", lines[1])
        with self.assertRaisesRegex(CampaignError, "position_m and force_N"):
            LoadCampaign(self.path)

    def test_one_run_without_them_is_told_by_its_name(self):
        self.write(
            lambda i, c: {
                n: v for n, v in c.items() if i != 1 or n != "position_m"
            }
        )
        code, lines = self.check()
        self.assertEqual((code, len(lines)), (2, 2))
        self.assertIn("error: long.csv: no columns to compare", lines[0])

    def test_runs_of_different_kinds_are_an_error_of_the_campaign(self):
        self.write(
            lambda i, c: {
                n.replace("force_N", "speed_command_m_s" if i else n): v
                for n, v in c.items()
            }
        )
        code, lines = self.check()
        self.assertEqual((code, len(lines)), (2, 2))
        self.assertIn("error: campaign.yaml: runs differ; allowed:", lines[0])

    def test_a_machine_that_never_moves_is_told_as_fit_tells_it(self):
        self.write(lambda _, c: {**c, "position_m": np.zeros(len(c["time_s"]))})
        self.assertNotIn(
            "error", {p.severity for p in CheckCampaign(self.path)}
        )
        said = self.refused().removeprefix(f"{self.path}: ")
        code, lines = self.check()
        self.assertEqual(code, 2)
        self.assertIn(f"error: {self.path}: {said}", lines)
        self.assertIn("position_m shows no more than its noise", said)

    def test_a_sound_axis_is_usable(self):
        self.write(lambda _, c: c)
        code, lines = self.check()
        self.assertEqual(code, 0, lines)
        MakeDevice(LoadCampaign(self.path))


class TestWays(unittest.TestCase):
    def test_each_way_alone_is_enough(self):
        ways = [way.columns for way in AXIS_WAYS]
        self.assertEqual(len({frozenset(way) for way in ways}), len(ways))
        for way in ways:
            with self.subTest(way):
                runs = {"a.csv": ("time_s", *way), "b.csv": (*way, "input_x")}
                self.assertEqual(check_ways(ways, runs, "m"), [])
                one = {"a.csv": ("time_s", way[0])}
                self.assertEqual(check_ways(ways, one, "m")[0].file, "a.csv")

    def test_what_is_not_used_beside_a_way_is_told(self):
        ways = [way.columns for way in AXIS_WAYS]
        columns = ("position_rad", "position_command_rad", "torque_N_m")
        (found,) = check_ways(ways, {"a.csv": columns}, "m")
        self.assertEqual(found.severity, "warning")
        self.assertEqual(
            found.message,
            "not used: torque_N_m; the twin takes position_rad and"
            " position_command_rad",
        )

    def test_a_device_without_ways_is_asked_for_none(self):
        self.assertEqual(check_ways((), {"a.csv": ()}, "m"), [])


if __name__ == "__main__":
    unittest.main()
