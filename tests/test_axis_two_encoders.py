"""A load behind its motor, both read: closed forms, and what was put in."""

import unittest
from pathlib import Path

import numpy as np

from brace_drake.devices.axis.follower import Commanded, simulate_response
from brace_drake.diagnosis import diagnose
from brace_drake.effects.registry import find_effect
from brace_drake.recording.recording import Campaign, Run

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


class TestLibrary(unittest.TestCase):
    def test_an_error_of_a_transmission_needs_both_encoders(self):
        card = find_effect("transmission_error")
        self.assertIn("two encoders", card.places)


if __name__ == "__main__":
    unittest.main()
