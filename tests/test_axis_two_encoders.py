"""A load behind its motor, both read: closed forms, and what was put in."""

import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.devices.axis.follower import (
    AxisFollower,
    Commanded,
    simulate_response,
)
from brace_drake.diagnosis import diagnose
from brace_drake.effects.registry import find_effect
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording_faults import check_recording
from brace_drake.scenario.axis import AxisScenario

RATE, NOISE, QUANTUM = 500.0, 2e-5, 2 * np.pi / 65536
# Amplitude, rad, frequency, Hz, and what each run is for.
RUNS = (
    (0.4, 0.3, "fit"),
    (0.15, 1.0, "fit"),
    (0.8, 0.15, "fit"),
    (0.3, 0.5, "validation"),
)


def motor_motion(size, frequency):
    """Two sines that begin at rest (N,), rad, and their times."""
    time = np.arange(4000) / RATE
    rise = 1.0 - np.exp(-time)
    w = 2.0 * np.pi * frequency * time
    return time, rise * (size * np.sin(w) + 0.1 * np.sin(2.1 * w))


def behind_play(motor, width=0.012):
    """A load that moves where the motor reaches an end of the play."""
    load = np.zeros_like(motor)
    for i in range(1, len(motor)):
        low, high = motor[i] - 0.5 * width, motor[i] + 0.5 * width
        load[i] = min(max(load[i - 1], low), high)
    return load


def behind_spring(motor, w=100.0, viscous=15.0, friction=30.0, parts=10):
    """A load of 1 kg m^2 on a spring, with friction, by small Euler steps."""
    step = 1.0 / RATE / parts
    fine = np.interp(
        np.arange(len(motor) * parts) * step,
        np.arange(len(motor)) / RATE,
        motor,
    )
    y = v = 0.0
    load = np.zeros(len(fine))
    for i, theta in enumerate(fine):
        a = w * w * (theta - y) - viscous * v - friction * np.tanh(v / 2e-3)
        v += step * a
        y += step * v
        load[i] = y
    return load[::parts]


def make_campaign(law) -> Campaign:
    """A campaign of one joint, both encoders quantised."""
    generator = np.random.default_rng(3)
    runs = []
    for i, (size, frequency, split) in enumerate(RUNS):
        time, motor = motor_motion(size, frequency)
        load = law(motor) + 0.02
        read = [
            QUANTUM
            * np.round(
                (x + NOISE * generator.standard_normal(len(x))) / QUANTUM
            )
            for x in (motor, load)
        ]
        columns = {
            "time_s": time,
            "motor_position_rad": read[0],
            "position_rad": read[1],
        }
        runs.append(Run(f"run{i}.csv", False, f"{i}", None, split, columns))
    return Campaign(Path("synthetic"), "axis", RATE, "", tuple(runs))


class TestLaw(unittest.TestCase):
    def test_on_a_motor_of_constant_speed_the_load_lags_by_its_drag(self):
        # Of y'' = w^2 (r - y) + 2 z w (r' - y') - b y' what stays is b v / w^2.
        w, z, b, speed = 80.0, 0.2, 12.0, 0.5
        time = np.arange(2000) / RATE
        motor = speed * time
        law = np.array([w * w, 2 * z * w + b, w * w, 0.0, 2 * z * w])
        motion = Commanded(time, motor, np.array([0.0, speed]))
        y = simulate_response(law, motion, 1.0, 2e-4, is_held=False)[:, 0]
        lag = b * speed / w**2
        self.assertAlmostEqual(motor[-1] - y[-1], lag, delta=1e-3 * lag)


class TestStart(unittest.TestCase):
    def test_where_a_run_starts_does_not_depend_on_the_encoders_zeros(self):
        starts = []
        for offset in (0.0, 3.0):
            scenario = AxisScenario(
                kind="rotary",
                command="motor",
                frequency=40.0,
                offset=offset,
                fitted=["frequency", "damping_ratio", "offset"],
            )
            time, motor = motor_motion(0.4, 0.3)
            # In the middle of the motion.
            columns = {
                "time_s": time[500:],
                "motor_position_rad": motor[500:],
                "position_rad": motor[500:] + offset,
            }
            run = Run("run.csv", False, "a", None, "fit", columns)
            starts.append(AxisFollower(scenario).motion(run).state)
        np.testing.assert_allclose(starts[1] - starts[0], [3.0, 0.0], atol=1e-6)

    def test_a_number_that_a_load_has_not_is_refused_by_name(self):
        scenario = AxisScenario(command="motor", fitted=["mass"])
        with self.assertRaisesRegex(ScenarioError, "fitted has mass"):
            AxisFollower(scenario)


class TestDiagnosis(unittest.TestCase):
    def test_a_rigid_joint_has_no_gap_and_its_offset_is_found(self):
        found = diagnose(make_campaign(lambda motor: motor), jobs=1)
        self.assertFalse(found.verdict.gap)
        (offset,) = found.estimates.parameters
        self.assertEqual(offset.name, "offset_rad")
        self.assertAlmostEqual(offset.value, 0.02, delta=1e-5)

    def test_play_between_motor_and_load_is_named_with_its_width(self):
        self.assert_named(behind_play, "backlash", "backlash_rad", 0.012)

    def test_a_gear_that_runs_out_is_named_with_its_pitch(self):
        def law(motor):
            return motor + 0.003 * np.sin(2 * np.pi * motor / 0.5)

        self.assert_named(law, "transmission_error", "pitch_rad", 0.5)

    def test_friction_that_winds_a_spring_is_told_from_play(self):
        self.assert_named(
            behind_spring, "coulomb_friction", "coulomb_rad_s2", 30.0, 0.05
        )

    def assert_named(self, law, name, parameter, value, within=0.01):
        found = diagnose(make_campaign(law), jobs=1)
        self.assertEqual(found.verdict.effects, (name,))
        (effect, values) = found.verdict.winner.uses[0]
        got = dict(zip(effect.parameter_names, values, strict=True))
        self.assertAlmostEqual(got[parameter], value, delta=within * value)


class TestRecording(unittest.TestCase):
    def test_a_load_that_is_never_read_is_stuck(self):
        campaign = make_campaign(behind_play)
        runs = list(campaign.runs)
        flat = np.full(4000, 0.3)
        columns = {**runs[1].channels, "position_rad": flat}
        runs[1] = replace(runs[1], channels=columns)
        found = check_recording(replace(campaign, runs=tuple(runs)))
        self.assertEqual([f.fault.name for f in found], ["stuck_channel"])

    def test_play_behind_a_coarse_encoder_is_not_stuck(self):
        time = np.arange(0.0, 10.0, 1e-3)
        motor = 0.02 * np.sin(2.0 * np.pi * 0.2 * time)
        load = 1e-3 * np.round(behind_play(motor, 0.02) / 1e-3)
        columns = {
            "time_s": time,
            "motor_position_rad": motor,
            "position_rad": load,
        }
        run = Run("run.csv", False, "a", None, "fit", columns)
        campaign = Campaign(Path("coarse"), "axis", 1000.0, "", (run,))
        self.assertEqual(check_recording(campaign), [])

    def test_an_answer_to_a_step_is_no_moved_zero(self):
        time = np.arange(0.0, 10.0, 0.1)
        command = 0.5 * (time >= 3.0)
        noise = 1e-4 * np.random.default_rng(1).standard_normal(100)
        columns = {
            "time_s": time,
            "position_command_rad": command,
            "position_rad": np.append(0.0, command[:-1]) + noise,
        }
        run = Run("run.csv", False, "a", None, "fit", columns)
        campaign = Campaign(Path("step"), "axis", 10.0, "", (run,))
        self.assertEqual(check_recording(campaign), [])


class TestLibrary(unittest.TestCase):
    def test_an_error_of_a_transmission_needs_both_encoders(self):
        card = find_effect("transmission_error")
        self.assertIn("two encoders", card.places)


if __name__ == "__main__":
    unittest.main()
