"""Runs that begin with the brace held, as recordings from a device do."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.cli.options import load_motion
from brace_drake.devices.bench.block_tests import bench_tests
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.effects.registry import find_effect
from brace_drake.recording import LoadCampaign, WriteCampaign
from brace_drake.recording.manifest import parse_manifest
from brace_drake.scenario.brace import BenchScenario

EXAMPLE = Path(__file__).parent / "data" / "example"


class TestTwin(unittest.TestCase):
    def setUp(self):
        self.twin = BenchTwin(BenchScenario(), 5e-4)
        self.subject = np.array([p.nominal for p in self.twin.subject])
        self.run_ = load_motion("push")

    def simulate(self, settled_s, *uses, generator=None):
        run = replace(self.run_, settled_s=settled_s)
        motion = self.twin.motion(run)
        log = self.twin.simulate(motion, self.subject, uses, generator)
        self.assertEqual(len(log), len(run.time_s))
        return log

    def test_without_an_effect_there_is_nothing_to_settle(self):
        np.testing.assert_allclose(
            self.simulate(4.0), self.simulate(0.0), atol=1e-9
        )

    def test_what_is_switched_on_is_over_before_the_first_sample(self):
        for name, value in (("force_bias", 0.3), ("command_delay", 0.004)):
            use = find_effect(name), np.array([value])
            cold, settled = self.simulate(0.0, use), self.simulate(4.0, use)
            rms = self.twin.numbers.noise_sigma[0]
            # The push begins softly: its first 0.1 s are still at rest.
            start = settled[:20, 6:12]
            self.assertLess(np.ptp(start, axis=0).max(), 0.1 * rms)
            self.assertGreater(np.ptp(cold[:20, 6:12], axis=0).max(), rms)
            # In the end both are the same.
            np.testing.assert_allclose(settled[-400:], cold[-400:], atol=1e-4)

    def test_its_noise_is_of_the_samples_that_are_there(self):
        generator = np.random.default_rng(1)
        log = self.simulate(1.0, generator=generator)
        exact = self.simulate(1.0)
        sigma = np.std((log - exact)[:, 6:12])
        self.assertGreater(sigma, 0.5 * self.twin.numbers.noise_sigma[0])

    def test_the_controller_alone_settles_on_what_the_recording_begins_with(
        self,
    ):
        use = find_effect("force_bias"), np.array([0.3])
        run = replace(self.run_, settled_s=2.0)
        motion = self.twin.motion(run)
        log = self.twin.simulate(motion, self.subject, (use,))
        controller = bench_tests(self.twin, 200.0)[0]

        class Prepared:
            pass

        prepared = Prepared()
        prepared.motion, prepared.run = motion, run
        prepared.floor = type("Floor", (), {"rms": np.ones(19)})
        residual = controller.residual(prepared, log)(self.subject)
        self.assertLess(np.abs(residual).max(), 0.05)


class TestFiles(unittest.TestCase):
    def test_a_campaign_keeps_it(self):
        campaign = LoadCampaign(EXAMPLE)
        self.assertEqual({r.settled_s for r in campaign.runs}, {0.0})
        runs = tuple(replace(r, settled_s=4.0) for r in campaign.runs)
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder, "out")
            WriteCampaign(replace(campaign, runs=runs), out)
            again = LoadCampaign(out)
        self.assertEqual({r.settled_s for r in again.runs}, {4.0})

    def test_what_is_no_time_is_refused(self):
        text = (EXAMPLE / "campaign.yaml").read_text()
        for value in ("-1", "soon", ".nan", "true"):
            data = f"settled_s: {value}\n{text}".encode()
            _, problems = parse_manifest(data)
            self.assertRegex(str(problems[0]), "settled_s must be a number")
