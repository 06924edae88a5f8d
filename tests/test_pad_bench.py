"""The pad bench: closed forms, and known parameters."""

import json
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.cli.main import main
from brace_drake.core.errors import CampaignError
from brace_drake.devices.device import MakeDevice
from brace_drake.devices.pad_bench.twin import PadBenchTwin
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording.write import WriteCampaign
from brace_drake.scenario.pad_bench import (
    MakePadBenchScenario,
    PadBenchScenario,
)
from tests.pad_recordings import (
    ARM,
    CUBIC,
    CYCLES,
    STAIRS,
    SUBJECT,
    exact_run,
    linear,
    make_campaign,
    make_run,
    relaxing,
    stiffening,
)


def use(name: str, **values: float):
    effect = find_effect(name)
    return effect, effect.vector(values)


class TestLaws(unittest.TestCase):
    def replay(self, run, uses=()):
        """The twin's force and where the rate of the path is not in doubt."""
        twin = PadBenchTwin(PadBenchScenario())
        subject = np.array(list(SUBJECT.values()))
        motion = twin.motion(run)
        force = twin.simulate(motion, subject, uses)[:, 0]
        d = run.channels["displacement_m"]
        corner = np.zeros(len(d), dtype=bool)
        corner[1:-1] = np.abs(np.diff(d, 2)) > 1e-9
        return force, ~corner

    def test_a_linear_contact_is_exact_between_corners(self):
        run = exact_run(CYCLES, linear)
        force, sure = self.replay(run)
        np.testing.assert_allclose(
            force[sure], run.channels["force_N"][sure], rtol=0.0, atol=1e-6
        )

    def test_ramp_and_hold_is_that_of_a_standard_linear_solid(self):
        run = exact_run(STAIRS, relaxing)
        arm, tau = ARM.values()
        uses = [use("relaxation", arm_stiffness_N_m=arm, relaxation_time_s=tau)]
        force, sure = self.replay(run, uses)
        # The arm lags by half a step of the state at the fastest ramp.
        bound = 0.5 * 0.0005 * arm * 0.02
        np.testing.assert_allclose(
            force[sure], run.channels["force_N"][sure], rtol=0.0, atol=bound
        )

    def test_hardening_adds_the_cube_of_the_depth(self):
        run = exact_run(STAIRS, stiffening)
        uses = [use("hardening", cubic_stiffness_N_m3=CUBIC)]
        force, _ = self.replay(run, uses)
        depth = 0.012 - SUBJECT["offset"]
        expected = SUBJECT["k"] * depth + CUBIC * depth**3
        self.assertAlmostEqual(force[-1], expected, delta=1e-9)

    def test_the_pad_never_pulls(self):
        run = exact_run(CYCLES, linear)
        force, _ = self.replay(run)
        self.assertEqual(force.min(), 0.0)
        shallow = run.channels["displacement_m"] < SUBJECT["offset"]
        self.assertEqual(np.abs(force[shallow]).max(), 0.0)

    def test_the_seed_decides_the_noise(self):
        campaign = make_campaign(linear)
        twin = PadBenchTwin(MakePadBenchScenario(campaign))
        motion = twin.motion(campaign.runs[0])
        subject = np.array([p.nominal for p in twin.subject])
        first, same, other = (
            twin.simulate(motion, subject, (), np.random.default_rng(seed))
            for seed in (1, 1, 2)
        )
        np.testing.assert_array_equal(first, same)
        self.assertGreater(np.abs(first - other).max(), 0.01)


class TestFit(unittest.TestCase):
    def fit_beside_floors_of(self, subject, twin, campaign):
        floors, _ = estimate_floors(twin, campaign, subject, seed=0)
        runs = campaign.split("fit")
        prepared = prepare_runs(twin, runs, floors, campaign.rate_hz, 0)
        return fit_nominal(Evaluator(twin, prepared, jobs=1))

    def check(self, campaign, tolerance):
        """Fits stiffness, damping and offset; `tolerance` (3,) is relative."""
        twin = MakeDevice(campaign).twin
        start = np.array([p.nominal for p in twin.subject])
        fit = self.fit_beside_floors_of(start, twin, campaign)
        ratio = fit.subject[:3] / list(SUBJECT.values())
        self.assertLess(np.max(np.abs(ratio - 1.0) / tolerance), 1.0)
        # No more than noise, whose level is the upper end of an estimate: of
        # the displacement's the damping that was found makes it.
        fit = self.fit_beside_floors_of(fit.subject, twin, campaign)
        rest = fit.excess / len(fit.solution.residual)
        self.assertLess(rest, 0.15)
        self.assertGreater(rest, -0.3)

    def test_the_subject_comes_back_without_any_nominal_values(self):
        self.check(make_campaign(linear), [1e-3, 1e-2, 1e-3])

    def test_it_does_from_a_nominal_far_away(self):
        nominal = {"stiffness_N_m": 4000.0, "damping_N_s_m": 100.0}
        self.check(make_campaign(linear, nominal), [1e-3, 1e-2, 1e-3])

    def test_it_does_from_slow_and_from_fast_recordings(self):
        for rate in (20.0, 1000.0):
            with self.subTest(rate=rate):
                campaign = make_campaign(linear, rate=rate)
                self.check(campaign, [2e-3, 2e-2, 1e-3])

    def test_a_pad_that_rests_is_refused(self):
        run = make_run("rest.csv", ([0, 5], [1, 1]), linear, 0,
                       displacement_noise=0.0)  # fmt: skip
        campaign = replace(make_campaign(linear), runs=(run,))
        with self.assertRaisesRegex(CampaignError, "does not move"):
            MakeDevice(campaign)

    def test_a_force_that_never_changes_is_refused(self):
        run = make_run("dead.csv", CYCLES, lambda m, t: 0.0 * t, 0,
                       force_noise=0.0)  # fmt: skip
        campaign = replace(make_campaign(linear), runs=(run,))
        with self.assertRaisesRegex(CampaignError, "force does not change"):
            MakeDevice(campaign)

    def test_a_pad_that_moves_and_never_touches_is_refused(self):
        campaign = make_campaign(lambda motion, time: 0.0 * time)
        with self.assertRaisesRegex(CampaignError, "no more than its noise"):
            MakeDevice(campaign)

    def test_the_fit_command_takes_a_pad(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "campaign"
            WriteCampaign(make_campaign(linear), path)
            out = Path(folder) / "out"
            self.assertEqual(main(["fit", str(path), "--out", str(out)]), 0)
            document = json.loads((out / "fit.json").read_text())
        for p, truth in zip(
            document["parameters"], SUBJECT.values(), strict=False
        ):
            error = abs(p["value"] - truth)
            self.assertLess(error, 4.0 * p["standard_error"], p["name"])


if __name__ == "__main__":
    unittest.main()
