"""The leg bench: closed forms, the twin's interface, known parameters."""

import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_load_typed

from brace_drake.core.errors import BraceError
from brace_drake.core.resources import scenario_path
from brace_drake.devices.leg_bench.twin import LegBenchTwin, LegMotion
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.leg_bench import (
    LegBenchScenario,
    MakeLegBenchScenario,
    estimate_position_noise,
    white_part,
)

RATE = 1000.0
CONTROL = {"kp_1_s": 160.18, "kv_N_s_m": 8557.27, "force_limit_N": 351.5}
NOMINAL = {"mass_kg": 95.0, "viscous_N_s_m": 200.0}
SUBJECT = np.array([100.0, 180.0, -3.0])


def starts_of(name: str, **values: float):
    """An effect with its card's first starts, some values replaced."""
    effect = find_effect(name)
    start = dict(zip(effect.parameter_names, effect.starts()[0], strict=True))
    return effect, effect.vector(start | values)


def make_motion(
    desired=None, added=None, load=None, ticks: int = 400, closed: bool = True
) -> LegMotion:
    """A motion from rest at zero."""
    asked = np.zeros((ticks, 3))
    for column, values in enumerate((desired, added, load)):
        if values is not None:
            asked[:, column] = values
    return LegMotion(asked, np.zeros(2), np.zeros(2), closed)


def make_campaign(seconds: float = 4.0, uses=(), noise: float = 2e-8):
    """Two synthetic runs of a drive with the parameters SUBJECT."""
    time = np.arange(round(seconds * RATE)) / RATE
    scenario = LegBenchScenario(position_noise=noise)
    runs = []
    for i, (split, a, f) in enumerate(
        (("fit", 0.02, 0.5), ("validation", 0.015, 0.8))
    ):
        desired = a * (1.0 - np.cos(2.0 * np.pi * f * time))
        desired += 0.002 * (1.0 - np.cos(2.0 * np.pi * 3.1 * time))
        # At half the twin's plant step, to which fits are corrected.
        twin = LegBenchTwin(scenario).finer()
        log = twin.simulate(
            make_motion(desired, ticks=len(time)),
            SUBJECT,
            uses,
            np.random.default_rng(i),
        )
        channels = {
            "time_s": time,
            "force_command_N": log[:, 0],
            "position_m": log[:, 1],
            "position_desired_m": desired,
        }
        runs.append(Run(f"run{i}.csv", False, "sines", None, split, channels))
    return Campaign(
        Path("synthetic"), "leg bench", RATE, "", tuple(runs), NOMINAL, CONTROL
    )


def make_twin(**changes) -> LegBenchTwin:
    return LegBenchTwin(replace(LegBenchScenario(), **changes))


class TestLaws(unittest.TestCase):
    def test_a_constant_force_gives_the_first_order_response(self):
        twin, force = make_twin(), 60.0
        mass, viscous, offset = SUBJECT
        motion = make_motion(added=force, closed=False)
        position = twin.simulate(motion, SUBJECT)[:, 1]
        time, tau = np.arange(400) / RATE, mass / viscous
        v_end = (force - offset) / viscous
        exact = v_end * (time - tau * (1.0 - np.exp(-time / tau)))
        # Euler: one step too far, dt * v, at the most.
        bound = twin.time_step * v_end
        np.testing.assert_allclose(position, exact, rtol=0.0, atol=bound)
        step, count = twin.time_step, 5 * np.arange(400)
        decay = 1.0 - step / tau
        total = count - decay * (1.0 - decay**count) / (1.0 - decay)
        np.testing.assert_allclose(
            position, v_end * step * total, rtol=0.0, atol=1e-12
        )

    def test_a_ramp_takes_friction_offset_and_the_servo_s_lag(self):
        time, speed = np.arange(3000) / RATE, 0.05
        motion = make_motion(speed * time, ticks=3000)
        for coulomb in (0.0, 20.0):
            with self.subTest(coulomb=coulomb):
                uses = [starts_of("coulomb_friction", coulomb_N=coulomb)]
                log = make_twin().simulate(motion, SUBJECT, uses)
                u, y = log[-1]
                expected = SUBJECT[1] * speed + SUBJECT[2] + coulomb
                # What is left of the transient and, for tanh-like laws, of
                # friction not yet developed.
                self.assertAlmostEqual(u, expected, delta=1e-4)
                kp, kv = make_twin().numbers.control[:2]
                lag = (u / kv + speed) / kp
                self.assertAlmostEqual(speed * time[-1] - y, lag, delta=1e-9)

    def test_an_external_load_needs_the_opposite_command(self):
        motion = make_motion(load=10.0, ticks=3000)
        u = make_twin().simulate(motion, SUBJECT)[-1, 0]
        self.assertAlmostEqual(u, SUBJECT[2] - 10.0, delta=1e-6)

    def test_the_command_keeps_to_its_limit(self):
        motion = make_motion(desired=1.0)
        log = make_twin().simulate(motion, SUBJECT)
        self.assertEqual(log[:, 0].max(), 351.5)

    def test_a_dead_time_shifts_the_response_by_as_many_ticks(self):
        motion = make_motion(added=30.0, closed=False)
        subject = np.array([100.0, 180.0, 0.0])
        uses = [starts_of("command_delay", delay_s=0.007)]
        prompt = make_twin().simulate(motion, subject)[:, 1]
        late = make_twin().simulate(motion, subject, uses)[:, 1]
        np.testing.assert_allclose(late[7:], prompt[:-7], atol=1e-10)

    def test_play_holds_the_reading_until_half_of_it_is_used_up(self):
        motion = make_motion(added=30.0, closed=False)
        uses = [starts_of("backlash", backlash_m=2e-3)]
        true = make_twin().simulate(motion, SUBJECT)[:, 1]
        read = make_twin().simulate(motion, SUBJECT, uses)[:, 1]
        expected = true[0] + np.maximum(true - true[0] - 1e-3, 0.0)
        np.testing.assert_allclose(read, expected, rtol=0.0, atol=1e-12)

    def test_more_viscous_friction_is_the_same_as_effect_or_subject(self):
        time = np.arange(400) / RATE
        motion = make_motion(0.01 * np.sin(9.0 * time) ** 2)
        uses = [starts_of("viscous_leg", extra_viscous_N_s_m=50.0)]
        more = SUBJECT + np.array([0.0, 50.0, 0.0])
        np.testing.assert_allclose(
            make_twin().simulate(motion, SUBJECT, uses),
            make_twin().simulate(motion, more),
            atol=1e-9,
        )

    def test_a_run_that_breaks_down_is_an_error(self):
        twin = make_twin()
        twin.numbers.control[1] = -1e6
        with self.assertRaisesRegex(BraceError, "broke down at"):
            twin.simulate(make_motion(desired=0.1, load=1e9), SUBJECT)


class TestTwin(unittest.TestCase):
    def test_the_scenario_file_holds_the_default_scenario(self):
        path = scenario_path("leg_bench.scenario.yaml")
        loaded = yaml_load_typed(schema=LegBenchScenario, filename=str(path))
        self.assertEqual(loaded, LegBenchScenario())

    def test_a_replay_of_its_own_recording_leaves_only_noise(self):
        campaign = make_campaign()
        twin = LegBenchTwin(MakeLegBenchScenario(campaign))
        for run in campaign.runs:
            replay = twin.simulate(twin.motion(run), SUBJECT)
            rest = twin.measured(run) - replay
            # Past the initial velocity, which is known but to 1e-6 m/s.
            self.assertLess(np.std(rest[100:, 0]), 0.3)
            self.assertLess(np.std(rest[100:, 1]), 5e-8)
            np.testing.assert_array_equal(twin.active(run), [True, False])

    def test_the_seed_decides_the_noise(self):
        motion = make_motion(desired=0.001)
        twin = make_twin(position_noise=1e-6)
        first, same, other = (
            twin.simulate(motion, SUBJECT, (), np.random.default_rng(seed))
            for seed in (1, 1, 2)
        )
        np.testing.assert_array_equal(first, same)
        self.assertGreater(np.abs(first - other).max(), 1e-6)

    def test_the_recordings_show_their_reading_noise(self):
        sigma = 3e-7
        campaign = make_campaign(noise=sigma)
        # In closed loop the drive itself follows little of that band.
        found = estimate_position_noise(campaign.runs)
        self.assertAlmostEqual(found / sigma, 1.0, delta=0.1)
        signal = np.random.default_rng(0).normal(0.0, 2.0, 20000)
        self.assertAlmostEqual(white_part(signal), 2.0, delta=0.1)

    def test_an_external_force_is_added_once(self):
        run = make_campaign().runs[0]
        pulse = np.zeros(len(run.time_s))
        pulse[1000:1200] = 50.0
        twin = make_twin()
        for inside, column in ((1.0, 1), (0.0, 2)):
            command = run.channels["force_command_N"] + inside * pulse
            changed = run.channels | {
                "external_force_N": pulse,
                "force_command_N": command,
            }
            asked = twin.motion(replace(run, channels=changed)).asked
            np.testing.assert_allclose(asked[:, column], pulse, atol=1e-9)
            self.assertEqual(np.abs(asked[:, 3 - column]).max(), 0.0)

    def test_without_control_the_recorded_command_drives_the_bench(self):
        campaign = replace(make_campaign(), control={})
        twin = LegBenchTwin(MakeLegBenchScenario(campaign))
        run = campaign.runs[0]
        motion = twin.motion(run)
        self.assertFalse(motion.closed)
        replay = twin.simulate(motion, SUBJECT)
        np.testing.assert_allclose(
            replay[:, 0], run.channels["force_command_N"], atol=1e-9
        )
        # The initial velocity's error, 1e-6 m/s, drifts on.
        np.testing.assert_allclose(
            replay[:, 1], run.channels["position_m"], atol=1e-5
        )
        np.testing.assert_array_equal(twin.active(run), [False, True])

    def test_known_parameters_come_back(self):
        uses = [starts_of("coulomb_friction", coulomb_N=15.0)]
        campaign = make_campaign(uses=uses)
        twin = LegBenchTwin(MakeLegBenchScenario(campaign))
        nominal = np.array([p.nominal for p in twin.subject])
        floors, _ = estimate_floors(twin, campaign, nominal, seed=0)
        prepared = prepare_runs(twin, campaign.split("fit"), floors, RATE, 0)
        evaluator = Evaluator(twin, prepared, jobs=2)
        base = fit_nominal(evaluator)
        card = uses[0][0]
        fit = fit_effects(evaluator, [card], card.starts()[:1])
        # A thousandth is some ten standard errors, and the coarse part of
        # the search's own tolerance.
        np.testing.assert_allclose(fit.subject, SUBJECT, rtol=1e-3)
        self.assertAlmostEqual(fit.values[0][0], 15.0, delta=0.015)
        self.assertGreater(base.excess, 100.0 * abs(fit.excess))


if __name__ == "__main__":
    unittest.main()
