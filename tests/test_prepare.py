"""Preparing runs: channels that were not recorded have no weight."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices.device import MakeDevice
from brace_drake.identification.prepare import (
    check_motion,
    estimate_floors,
    prepare_runs,
)
from brace_drake.recording import LoadCampaign
from tests.shared_data import EXAMPLE


class TestMissing(unittest.TestCase):
    def test_a_marker_that_was_not_recorded_weighs_nothing(self):
        campaign = LoadCampaign(EXAMPLE)
        twin = MakeDevice(campaign).twin
        floors, _ = floors_of(campaign)
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


class TestMotion(unittest.TestCase):
    def test_runs_that_show_noise_alone_are_refused(self):
        campaign = LoadCampaign(EXAMPLE)
        floors, _ = floors_of(campaign)
        twin, fit = MakeDevice(campaign).twin, campaign.split("fit")
        moving = prepare_runs(twin, fit, floors, campaign.rate_hz, 0)
        check_motion("folder", moving)
        noise = np.random.default_rng(0)
        still = [
            replace(
                p, measured=noise.normal(0.0, p.floor.rms, p.measured.shape)
            )
            for p in moving
        ]
        # White noise of the floor's size is no more than coloured noise of it.
        limit = [replace(p, weights=0.5 * p.weights) for p in still]
        with self.assertRaisesRegex(CampaignError, "moves by more"):
            check_motion("folder", limit)
        check_motion("folder", [*limit[1:], moving[0]])


def floors_of(campaign):
    """Floors of a campaign, and the ratios that its repeats have set."""
    twin = MakeDevice(campaign).twin
    subject = np.array([p.nominal for p in twin.subject])
    return estimate_floors(twin, campaign, subject, 0)


def with_run(campaign, name, **changes):
    """A campaign with one of its runs changed."""
    runs = [
        replace(r, **changes) if r.file == name else r for r in campaign.runs
    ]
    return replace(campaign, runs=tuple(runs))


class TestFloors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.campaign = LoadCampaign(EXAMPLE)
        _, cls.ratios = floors_of(cls.campaign)

    def test_a_copy_of_a_run_is_no_repeat_of_it(self):
        push = next(r for r in self.campaign.runs if r.file == "push.csv")
        copied = with_run(
            self.campaign, "push_repeat.csv", channels=push.channels
        )
        floors, ratios = floors_of(copied)
        self.assertEqual(ratios, {})
        self.assertTrue(np.all(floors[True].rms > 0.0))

    def test_readings_of_what_is_held_back_set_no_floor(self):
        held = next(r for r in self.campaign.runs if r.split == "validation")
        torn = {
            name: values
            if "desired" in name or name.startswith("time")
            else np.round(values, 1)
            for name, values in held.channels.items()
        }
        turned = replace(self.campaign, runs=self.campaign.runs[::-1])
        self.assertEqual(turned.runs[0].file, held.file)
        whole, _ = floors_of(turned)
        found, _ = floors_of(with_run(turned, held.file, channels=torn))
        np.testing.assert_array_equal(found[True].rms, whole[True].rms)
        repeat = replace(held, file="again.csv", repeat_of=held.file)
        repeat = replace(repeat, split="fit", channels=torn)
        found = replace(self.campaign, runs=(*self.campaign.runs, repeat))
        self.assertEqual(floors_of(found)[1], self.ratios)


if __name__ == "__main__":
    unittest.main()
