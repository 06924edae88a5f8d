"""One axis under a command: closed forms, and limits that are found again."""

import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from brace_drake.devices.axis.follower import Commanded, simulate_response
from brace_drake.devices.device import MakeDevice
from brace_drake.diagnosis import diagnose
from brace_drake.effects.registry import find_effect
from brace_drake.recording.recording import Campaign, Run

RATE, NOISE = 100.0, 1e-4
FINE = 20
# Outer gain of each run, 1/s, and what it is for.
GAINS = ((2.0, "fit"), (5.0, "fit"), (9.0, "fit"), (5.0, "validation"))


def move(reference, gain, seed, law, lag=0.05, delay=0.0):
    """A joint under an outer position control: command and reading (N,).

    Args:
        reference: Asked for (N,), rad.
        gain: Of the outer control, 1/s.
        seed: Of the noise of the readings.
        law: From (commanded, speed, acceleration, step) to the acceleration.
        lag: Of the speed loop, s.
        delay: Of the command, s.
    """
    step = 1.0 / RATE / FINE
    generator = np.random.default_rng(seed)
    late = [0.0] * round(delay / step)
    y = v = 0.0
    command, reading = [], []
    for asked in reference:
        seen = y + NOISE * generator.standard_normal()
        command.append(gain * (asked - seen))
        reading.append(seen)
        for _ in range(FINE):
            late.append(command[-1])
            r = late.pop(0)
            rise = step * law(r, v, (r - v) / lag, step)
            y += step * (v + 0.5 * rise)
            v += rise
    return np.array(command), np.array(reading)


def make_campaign(
    law=lambda r, v, a, h: a, rest=1.0, gains=GAINS, size=1.0, **numbers
) -> Campaign:
    """A campaign of one joint.

    Args:
        law: See `move`.
        rest: How many times as far the first step goes.
        gains: Of the outer control of each run, and what it is for.
        size: Of the steps, rad.
        numbers: As `move` takes them.
    """
    time, runs = np.arange(1200) / RATE, []
    for i, (gain, split) in enumerate(gains):
        steps = np.random.default_rng(100 + i).uniform(-size, size, 8)
        steps[0] *= rest
        command, y = move(np.repeat(steps, 150), gain, i, law, **numbers)
        columns = {
            "time_s": time,
            "speed_command_rad_s": command,
            "position_rad": y,
        }
        runs.append(Run(f"run{i}.csv", False, f"{i}", None, split, columns))
    return Campaign(Path("synthetic"), "axis", RATE, "", tuple(runs))


def servo_run(i: int, split: str, time, asked, reading) -> Run:
    """A run of a commanded position and its reading, rad (N,)."""
    columns = {
        "time_s": time,
        "position_command_rad": asked,
        "position_rad": np.array(reading),
    }
    return Run(f"run{i}.csv", False, f"{i}", None, split, columns)


def make_servo(band, gain=22.0, lag=0.035) -> Campaign:
    """A campaign of a servo with a gain inside and a dead band, rad."""
    time, runs = np.arange(900) / RATE, []
    for i, split in enumerate(("fit", "fit", "fit", "validation")):
        generator = np.random.default_rng(40 + i)
        asked = np.repeat(generator.uniform(-0.6, 0.6, 9), 100)
        asked[:100] = y = v = 0.0
        reading = []
        for r in asked:
            reading.append(y + NOISE * generator.standard_normal())
            for _ in range(FINE):
                error = r - y if abs(r - y) >= band else 0.0
                v += (gain * error - v) / lag / RATE / FINE
                y += v / RATE / FINE
        runs.append(servo_run(i, split, time, asked, reading))
    return Campaign(Path("synthetic"), "axis", RATE, "", tuple(runs))


def make_cascade(friction=0.0, loop=20.0, speed=80.0, rate=15.0, own=3.0):
    """A campaign of a position loop around a speed loop with an integral.

    v' = speed (u - v) + i - own v - friction, u = loop (r - y),
    i' = rate speed (u - v).
    """
    time, runs = np.arange(1000) / RATE, []
    for i, split in enumerate(("fit", "fit", "fit", "validation")):
        generator = np.random.default_rng(70 + i)
        tones = 2.0 * np.pi * generator.uniform(0.1, 1.5, (3, 1))
        phase = generator.uniform(0.0, 6.0, (3, 1))
        asked = np.sum(0.3 * np.sin(tones * time + phase), axis=0)
        asked *= np.minimum(1.0, time) ** 2
        y = v = held = 0.0
        reading, h = [], 1.0 / RATE / FINE
        for r in asked:
            reading.append(y + NOISE * generator.standard_normal())
            for _ in range(FINE):
                error = speed * (loop * (r - y) - v)
                push = error + held - own * v
                after = v + h * push
                after -= np.clip(after, -h * friction, h * friction)
                y += 0.5 * h * (v + after)
                held, v = held + h * rate * error, after
        runs.append(servo_run(i, split, time, asked, reading))
    return Campaign(Path("synthetic"), "axis", RATE, "", tuple(runs))


class TestLaws(unittest.TestCase):
    def test_a_speed_command_is_followed_with_its_lag(self):
        time, lag, speed = np.arange(200) / RATE, 0.1, 0.7
        motion = Commanded(time, np.full(200, speed), np.zeros(2))
        law = np.array([1.0 / lag, 1.0 / lag, 0.0, 0.0])
        log = simulate_response(law, motion, 1.0, 1e-3)
        wanted = speed * (1.0 - np.exp(-time / lag))
        np.testing.assert_allclose(log[:, 1], wanted, atol=1e-12)

    def test_a_speed_controller_with_an_integral_follows_as_the_plane_does(
        self,
    ):
        # v' = (r - v) / T + i - b v, i' = n (r - v) / T: a plane of two
        # linear equations.
        time, lag, rate, damping, speed = (
            np.arange(200) / RATE,
            0.1,
            4.0,
            2.0,
            0.7,
        )
        motion = Commanded(time, np.full(200, speed), np.zeros(2))
        law = [1.0 / lag, 1.0 / lag, 0.0, 0.0, 0.0, rate, 0.0, damping]
        log = simulate_response(np.array(law), motion, 1.0, 1e-4)
        plane = np.array(
            [[-1.0 / lag - damping, 1.0, 1.0 / lag],
             [-rate / lag, 0.0, rate / lag],
             [0.0, 0.0, 0.0]]
        )  # fmt: skip
        state = np.array([0.0, 0.0, speed])
        wanted = [(expm(plane * t) @ state)[0] for t in time]
        np.testing.assert_allclose(log[:, 1], wanted, atol=1e-5)

    def test_a_cascade_with_an_integral_follows_as_its_equations_do(self):
        # y'' = w^2 (r - y) + 2 z w (f r' - y') + i - b y', r = t, and
        # i' = n (w^2 (r - y) + 2 z w (f r' - y')).
        time, w, z, forward, rate, b = (
            np.arange(200) / RATE,
            9.0,
            0.8,
            0.4,
            5.0,
            3.0,
        )
        d = 2.0 * z * w
        motion = Commanded(time, time, np.zeros(2))
        law = [w * w, d, w * w, 0.0, forward * d, rate, forward * d, b]
        log = simulate_response(np.array(law), motion, 1.0, 2e-4, is_held=False)

        def slopes(t, x):
            asked = w * w * (t - x[0]) + d * (forward - x[1])
            return [x[1], asked + x[2] - b * x[1], rate * asked]

        wanted = solve_ivp(
            slopes, (0.0, time[-1]), np.zeros(3), t_eval=time, rtol=1e-9,
            atol=1e-12,
        )  # fmt: skip
        np.testing.assert_allclose(log[:, 0], wanted.y[0], atol=2e-6)

    def test_a_position_command_is_followed_as_by_an_oscillator(self):
        time, w, z = np.arange(300) / RATE, 8.0, 0.3
        motion = Commanded(time, np.ones(300), np.zeros(2))
        law = np.array([w * w, 2.0 * z * w, w * w, 0.0])
        log = simulate_response(law, motion, 1.0, 1e-3)
        turn = w * np.sqrt(1.0 - z * z)
        fade = np.exp(-z * w * time)
        wanted = 1.0 - fade * (
            np.cos(turn * time) + z * w / turn * np.sin(turn * time)
        )
        np.testing.assert_allclose(log[:, 0], wanted, atol=2e-5)

    def test_a_late_position_command_is_followed_later_and_no_other_way(self):
        time, w, late = np.arange(200) / RATE, 8.0, 0.03
        law = np.array([w * w, 2.0 * w, w * w, 0.0])
        command = np.where(time >= 0.5, 1.0, 0.0)
        motion = Commanded(time, command, np.zeros(2))
        uses = [(find_effect("command_delay"), np.array([late]))]
        log = simulate_response(law, motion, 1.0, 1e-3, uses)
        t = np.maximum(time - 0.5 - late, 0.0)
        wanted = 1.0 - np.exp(-w * t) * (1.0 + w * t)
        np.testing.assert_allclose(log[:, 0], wanted, atol=2e-4)

    def test_a_limited_acceleration_makes_straight_lines(self):
        time, limit = np.arange(100) / RATE, 0.4
        motion = Commanded(time, np.ones(100), np.zeros(2))
        law = np.array([100.0, 100.0, 0.0, 0.0])
        uses = [(find_effect("acceleration_limit"), np.array([limit]))]
        log = simulate_response(law, motion, 1.0, 1e-4, uses)
        np.testing.assert_allclose(log[:, 1], limit * time, rtol=0.01)

    def test_dry_friction_takes_its_share_of_a_commanded_speed(self):
        # 0 = (r - v) / T - c, and none of a speed below c T.
        time, lag, friction = np.arange(300) / RATE, 0.1, 2.0
        law = np.array([1.0 / lag, 1.0 / lag, 0.0, 0.0])
        uses = [(find_effect("coulomb_friction"), np.array([friction]))]
        for speed, wanted in ((0.7, 0.5), (0.15, 0.0)):
            motion = Commanded(time, np.full(300, speed), np.zeros(2))
            log = simulate_response(law, motion, 1.0, 1e-3, uses)
            self.assertAlmostEqual(log[-1, 1], wanted, delta=2e-4)


class TestAnswers(unittest.TestCase):
    def check(self, campaign, name, parameter=None, value=0.0, delta=0.0):
        """Checks which effect is named, and how large it is."""
        found = diagnose(campaign, jobs=1)
        self.assertEqual(found.verdict.effects, (name,) if name else ())
        if parameter is None:
            return
        (effect, values) = found.verdict.winner.uses[0]
        got = dict(zip(effect.parameter_names, values, strict=True))
        self.assertAlmostEqual(got[parameter], value, delta=delta)

    def test_a_joint_that_follows_has_no_gap(self):
        campaign = make_campaign()
        found = diagnose(campaign, jobs=1)
        self.assertFalse(found.verdict.gap)
        lag = found.estimates.parameters[0]
        self.assertEqual(lag.name, "lag_s")
        self.assertAlmostEqual(lag.value, 0.05, delta=0.001)

    def test_a_cascade_with_an_integral_has_no_gap(self):
        self.check(make_cascade(), "")

    def test_friction_behind_an_integral_is_named(self):
        self.check(make_cascade(friction=12.0), "coulomb_friction")

    def test_a_limit_of_acceleration_is_no_lag_and_no_dead_time(self):
        campaign = make_campaign(lambda r, v, a, h: np.clip(a, -6.0, 6.0))
        self.check(
            campaign, "acceleration_limit", "acceleration_rad_s2", 6.0, 0.15
        )

    def test_a_ramp_before_the_loop_is_a_limit_of_acceleration_too(self):
        ramp = np.zeros(1)

        def law(r, v, a, h, lag=0.05):
            # At rest a run begins.
            ramp[0] = ramp[0] * (v != 0.0)
            ramp[0] += np.clip(r - ramp[0], -6.0 * h, 6.0 * h)
            return (ramp[0] - v) / lag

        campaign = make_campaign(law)
        self.check(
            campaign, "acceleration_limit", "acceleration_rad_s2", 6.0, 0.05
        )

    def test_a_speed_that_was_recorded_alone_will_do(self):
        campaign = make_campaign(lambda r, v, a, h: np.clip(a, -6.0, 6.0))
        runs = []
        for run in campaign.runs:
            columns = dict(run.channels)
            y = columns.pop("position_rad")
            columns["speed_rad_s"] = np.gradient(y, run.time_s)
            runs.append(replace(run, channels=columns))
        campaign = replace(campaign, runs=tuple(runs))
        self.check(
            campaign, "acceleration_limit", "acceleration_rad_s2", 6.0, 0.2
        )

    def test_a_servo_that_stops_short_within_its_band_is_told_how_wide(self):
        # 0.02 rad ask for 22 times as much speed.
        campaign = make_servo(band=0.02)
        self.check(campaign, "command_deadzone", "deadzone_rad_s", 0.44, 0.02)

    def test_a_limit_of_speed_is_named(self):
        campaign = make_campaign(
            lambda r, v, a, h: np.clip(v + h * a, -1.5, 1.5) / h - v / h
        )
        self.check(campaign, "speed_limit", "speed_rad_s", 1.5, 0.02)

    def test_a_dead_time_is_named(self):
        campaign = make_campaign(delay=0.03)
        self.check(campaign, "command_delay", "delay_s", 0.03, 0.002)

    def test_a_long_dead_time_is_named_too(self):
        campaign = make_campaign(delay=0.12, rest=0.0)
        self.check(campaign, "command_delay", "delay_s", 0.12, 0.002)

    def test_the_command_decides_what_an_axis_is_given(self):
        device = MakeDevice(make_campaign())
        self.assertEqual(device.twin.channels, ("speed_rad_s",))
        effects = device.twin.effects()
        # No force is known: what acts as one is told for 1 kg m^2.
        (friction,) = effects["coulomb_friction (that stops)"].parameters
        self.assertEqual(
            (friction.name, friction.unit), ("coulomb_rad_s2", "rad/s^2")
        )
        self.assertNotIn("force_gain", effects)


if __name__ == "__main__":
    unittest.main()
