"""The safety supervisor: limits, latched stops, and the damped release."""

import math
import tempfile
import unittest
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from brace_drake.core.errors import LimitsError
from brace_drake.link.device import safety
from brace_drake.link.device.guards import Trip, check_shared, pad_force
from brace_drake.link.device.limits_file import LoadLimits, check_limits
from brace_drake.link.device.release import (
    cut_stiffness,
    limit_command,
    release_command,
    remaining,
)
from brace_drake.link.device.safety_memory import (
    Reading,
    SafetyMode,
    Setup,
    start_memory,
)
from brace_drake.link.protocol.limits import (
    DEFAULT,
    LIMITS,
    SHARED,
    refuse_wider,
    shared_values,
)
from brace_drake.link.protocol.words import Cause
from brace_drake.model.systems.safety_supervisor import SafetySupervisor

HOLD = (2.0,) * 6
SETUP = Setup(DEFAULT, HOLD)
REST = (0.141,) * 6
STILL = (0.0, 0.0, 0.0)


def armed(n=20):
    """A supervisor armed at rest, and its time."""
    memory = start_memory(SETUP)
    for i in range(n):
        reading = Reading(1e-3 * i, REST, STILL)
        memory = safety.advance(SETUP, memory, 1e-3 * i, reading, HOLD)
    return safety.arm(memory), 1e-3 * n


def tick(memory, now, command=HOLD, setup=SETUP, **reading):
    read = {"time": now, "leg_length": REST, "force": STILL, **reading}
    return safety.advance(setup, memory, now, Reading(**read), command)


class TestLimits(unittest.TestCase):
    def test_the_file_holds_the_defaults_with_every_limit_in_it(self):
        self.assertEqual(LoadLimits(), DEFAULT)

    def test_bad_files_are_told_in_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "limits.yaml"
            for text, words in (
                ("leg_forse: 3", "did you mean leg_force"),
                ("leg_force: high", "leg_force is 'high'"),
                ("leg_force: -1", "greater than 0"),
                ("leg_force: .nan", "greater than 0"),
                ("leg_shortest: 0.2", "less than leg_longest"),
                ("[1]", "must hold a mapping"),
                ("a: [", "not YAML"),
            ):
                path.write_text(text)
                with self.assertRaises(LimitsError) as caught:
                    LoadLimits(path)
                self.assertIn(words, str(caught.exception))
                self.assertNotIn("\n", str(caught.exception))
            with self.assertRaisesRegex(LimitsError, "cannot be read"):
                LoadLimits(Path(folder) / "none.yaml")

    def test_every_shared_limit_that_is_wider_is_refused_by_name(self):
        device = shared_values(DEFAULT)
        refuse_wider(DEFAULT, device)
        for limit in SHARED:
            value = getattr(DEFAULT, limit.name)
            wider = value * (1.01 if limit.side == "most" else 0.99)
            tighter = value * (0.99 if limit.side == "most" else 1.01)
            refuse_wider(DEFAULT._replace(**{limit.name: tighter}), device)
            with self.assertRaisesRegex(LimitsError, limit.name):
                refuse_wider(DEFAULT._replace(**{limit.name: wider}), device)

    def test_no_limit_may_be_none_or_endless(self):
        for limit in LIMITS:
            for bad in (0.0, -1.0, math.inf, math.nan):
                with self.assertRaises(LimitsError):
                    check_limits(DEFAULT._replace(**{limit.name: bad}))


class TestCommands(unittest.TestCase):
    def test_a_command_within_limits_passes_unchanged(self):
        memory, now = armed()
        wanted = (2.5, 1.5, 2.0, 3.0, 0.0, -1.0)
        memory = tick(memory, now, wanted)
        self.assertEqual(memory.command, wanted)
        self.assertFalse(memory.clamped)

    def test_force_and_its_rate_are_cut(self):
        memory, now = armed()
        for _ in range(100):
            before = memory.command
            memory = tick(memory, now, (1e3, -1e3, 2.0, 2.0, 2.0, 2.0))
            now += 1e-3
            steps = np.abs(np.subtract(memory.command, before))
            most = DEFAULT.leg_force_rate * 1e-3
            self.assertLessEqual(steps.max(), most + 1e-9)
            self.assertTrue(memory.clamped)
        self.assertEqual(memory.command[:2], (40.0, -40.0))
        self.assertEqual(memory.mode, SafetyMode.ARMED)

    def test_a_command_that_is_no_number_stops(self):
        for bad in (math.nan, math.inf, -math.inf):
            memory, now = armed()
            memory = tick(memory, now, (bad, *HOLD[1:]))
            self.assertEqual(memory.trip.cause, Cause.BAD_COMMAND)
            self.assertTrue(np.isfinite(memory.command).all())

    def test_stiffness_keeps_its_limits_and_rates(self):
        first = (6e3,) * 3 + (100.0,) * 3
        # 0 throughout: none has passed so far, and no rate holds.
        self.assertEqual(cut_stiffness(DEFAULT, (0.0,) * 6, first, 1e-3), first)
        asked = (1e9, math.nan, -1.0, 1e9, math.nan, -1.0)
        values = [first]
        for _ in range(1000):
            values.append(cut_stiffness(DEFAULT, values[-1], asked, 1e-3))
        steps = np.abs(np.diff(values, axis=0)).max(axis=0)
        np.testing.assert_allclose(steps, [20, 0, 20, 0.4, 0, 0.4], rtol=1e-9)
        self.assertEqual(values[-1], (12e3, 6e3, 0.0, 200.0, 100.0, 0.0))


class TestWords(unittest.TestCase):
    def test_a_trip_says_value_and_limit_with_their_unit(self):
        for trip, text in (
            (
                Trip(Cause.LEG_SPEED, 2, 0.1234, 0.1),
                "leg speed: 123.4 mm/s, allowed 100 mm/s (leg 3)",
            ),
            (
                Trip(Cause.TOTAL_FORCE, 0, 81.0, 80.0),
                "total force: 81 N, allowed 80 N",
            ),
            (
                Trip(Cause.STALE_DATA, 0, 0.05025, 0.03),
                "stale data: the newest reading is 50 ms old, limit 30 ms"
                " (`stale` of the limits): this computer is too slow or too"
                " busy",
            ),
            (Trip(Cause.ESTOP), "estop"),
        ):
            with self.subTest(text=text):
                self.assertEqual(str(trip), text)


class TestTrips(unittest.TestCase):
    def assert_trips(self, cause, command=HOLD, **reading):
        memory, now = armed()
        memory = tick(memory, now, command, **reading)
        self.assertEqual(memory.mode, SafetyMode.STOPPED)
        self.assertEqual(memory.trip.cause, cause)
        return memory

    def with_leg(self, value):
        return (*REST[:2], value, *REST[3:])

    def test_each_limit_of_a_reading_stops_with_its_cause(self):
        tilted = (0.0,) * 3 + (0.0, 0.11, 0.0)
        far = (0.0, 0.017, 0.0, 0.0, 0.0, 0.0)
        zero = (0.0,) * 6
        for cause, reading in (
            (Cause.LEG_STROKE, {"leg_length": self.with_leg(0.11)}),
            (Cause.LEG_STROKE, {"leg_length": self.with_leg(0.17)}),
            (Cause.LEG_STROKE, {"leg_length": self.with_leg(math.nan)}),
            (Cause.JUMP, {"leg_length": self.with_leg(0.1416)}),
            (Cause.JUMP, {"force": (0.0, 5.1, 0.0)}),
            (Cause.PAD_FORCE, {"force": (0.0, -51.0, 0.0)}),
            (Cause.PAD_FORCE, {"force": (0.0, math.nan, 0.0)}),
            (Cause.TOTAL_FORCE, {"force": (70.0, 40.0, 0.0)}),
            (Cause.RING_POSE, {"pose": far}),
            (Cause.RING_POSE, {"pose": tilted}),
            (
                Cause.TRACKING,
                {"pose": zero, "virtual": (0.0, 0.0041, 0, 0, 0, 0)},
            ),
            (Cause.LOST_MESSAGES, {"lost": 21}),
            (Cause.NO_POSE, {"has_pose": False}),
        ):
            with self.subTest(cause=cause.name, **reading):
                trip = self.assert_trips(cause, **reading).trip
                self.assertIn(cause.name.lower().split("_")[0], str(trip))

    def test_just_within_each_limit_nothing_happens(self):
        for reading in (
            {"leg_length": self.with_leg(0.1414)},
            {"force": (0.0, 4.9, 0.0)},
            {"pose": (0.0, 0.0159, 0.0, 0.0, 0.09, 0.0)},
            {"lost": 20},
        ):
            memory, now = armed()
            memory = tick(memory, now, **reading)
            self.assertEqual(memory.mode, SafetyMode.ARMED)

    def test_speed_is_measured_over_its_low_pass(self):
        memory, now = armed()
        length, speed = 0.141, 0.12
        while memory.mode == SafetyMode.ARMED:
            now += 1e-3
            length += speed * 1e-3
            memory = tick(memory, now, leg_length=(length,) * 6)
            self.assertLess(now, 1.0)
        # 0.12 (1 - exp(-t / 0.02)) passes 0.1 at 35.8 ms.
        self.assertEqual(memory.trip.cause, Cause.LEG_SPEED)
        self.assertAlmostEqual(now - 0.02, 0.0358, delta=0.0015)

    def test_no_readings_are_stale_after_the_stated_time(self):
        memory, now = armed()
        last = now - 1e-3
        while memory.mode == SafetyMode.ARMED:
            now += 1e-3
            memory = safety.advance(SETUP, memory, now, None, HOLD)
            self.assertLess(now, 1.0)
        self.assertEqual(memory.trip.cause, Cause.STALE_DATA)
        self.assertAlmostEqual(now - last, DEFAULT.stale, delta=2e-3)

    def test_old_readings_that_go_on_coming_are_stale_too(self):
        memory, now = armed()
        memory = tick(memory, now + 0.05, time=now)
        self.assertEqual(memory.trip.cause, Cause.STALE_DATA)

    def test_force_and_legs_may_disagree_for_a_short_time_only(self):
        memory, now = armed()
        start = now
        expected = (0.0, 16.0, 0.0)
        for _ in range(150):
            memory = tick(memory, now, expected=expected)
            now += 1e-3
        self.assertEqual(memory.mode, SafetyMode.ARMED)
        memory = tick(memory, now, expected=(0.0, 14.0, 0.0))
        start = now + 1e-3
        while memory.mode == SafetyMode.ARMED:
            now += 1e-3
            memory = tick(memory, now, expected=expected)
            self.assertLess(now - start, 1.0)
        self.assertEqual(memory.trip.cause, Cause.DISAGREEMENT)
        self.assertAlmostEqual(now - start, 0.2, delta=2e-3)

    def test_a_reading_that_stands_still_while_others_travel_is_stuck(self):
        for stuck in (None, 4):
            memory, now = armed()
            for i in range(800):
                move = 1e-5 * i
                legs = [0.141 + move * s for s in (1, -1, 0.1, -0.1, 1, -1)]
                if stuck is not None:
                    legs[stuck] = 0.141
                memory = tick(memory, now, leg_length=legs)
                now += 1e-3
            if stuck is None:
                self.assertEqual(memory.mode, SafetyMode.ARMED)
            else:
                self.assertEqual(memory.trip.cause, Cause.STUCK_LEG)
                self.assertEqual(memory.trip.index, stuck)

    def test_the_pad_that_presses_more_is_found_from_their_difference(self):
        # k = 6400, preload 1 mm: pressed by x each pad has k (p +- x).
        k, p = 6400.0, 0.001
        for x in (0.0, 0.0003, 0.0009, 0.0015, 0.004):
            forces = max(0.0, k * (p + x)), max(0.0, k * (p - x))
            reading = (0.0, forces[0] - forces[1], 0.0)
            self.assertAlmostEqual(pad_force(reading, k * p), forces[0])

    def test_all_rings_are_looked_at(self):
        limits = DEFAULT
        force = [0.0, 0, 0, 0.0, 49.0, 0, 0.0, 32.0, 0]
        trip = check_shared(limits, [0.14] * 18, [0.0] * 18, force)
        self.assertEqual(trip.cause, Cause.TOTAL_FORCE)
        self.assertAlmostEqual(trip.value, 81.0)
        force[7], force[4] = 51.0, 0.0
        trip = check_shared(limits, [0.14] * 18, [0.0] * 18, force)
        self.assertEqual((trip.cause, trip.index), (Cause.PAD_FORCE, 2))


class TestLatch(unittest.TestCase):
    def test_a_stop_keeps_its_first_cause_until_it_is_cleared(self):
        memory, now = armed()
        memory = safety.stop(memory, Trip(Cause.STOP_KEY), now)
        memory = safety.stop(memory, Trip(Cause.ESTOP), now)
        self.assertEqual(memory.trip.cause, Cause.STOP_KEY)
        self.assertEqual(safety.arm(memory).mode, SafetyMode.STOPPED)
        memory = safety.clear(memory)
        memory = tick(memory, now + 9.0, (30.0,) * 6)
        self.assertEqual(memory.mode, SafetyMode.RELEASED)
        np.testing.assert_allclose(memory.command, HOLD, atol=1e-9)
        memory = safety.arm(memory)
        self.assertEqual(memory.mode, SafetyMode.ARMED)

    def test_no_function_changes_what_it_is_given(self):
        memory, now = armed()
        before = memory._asdict()
        safety.stop(memory, Trip(Cause.ESTOP), now)
        tick(memory, now, (9.0,) * 6, force=(0.0, 60.0, 0.0))
        self.assertEqual(memory._asdict(), before)


class TestRelease(unittest.TestCase):
    def test_it_goes_smoothly_from_the_load_to_the_weight(self):
        start, still = (20.0, -15.0, 2.0, 2.0, 2.0, 2.0), (0.0,) * 6
        times = np.linspace(0.0, 1.0, 501)
        out = np.array(
            [release_command(t, DEFAULT, start, HOLD, still) for t in times]
        )
        np.testing.assert_allclose(out[0], start)
        np.testing.assert_allclose(out[times >= 0.5], [HOLD] * 251, atol=1e-12)
        # |r'| <= 1.5 / T.
        rate = np.abs(np.gradient(out[:, 0], times)).max()
        self.assertLess(rate, 1.5 / 0.5 * 18.0 + 0.1)
        self.assertTrue((np.diff(out[:, 0]) <= 1e-12).all())
        self.assertEqual(remaining(0.25, 0.5), 0.5)

    def test_behind_it_only_damping_opposes_a_motion(self):
        speed = (0.1, -0.1, 0.0, 0.0, 0.0, 0.0)
        out = release_command(1.0, DEFAULT, (30.0,) * 6, HOLD, speed)
        push = np.subtract(out, HOLD)
        np.testing.assert_allclose(push, -20.0 * np.array(speed), atol=1e-12)

    def test_a_pressed_ring_is_let_go_within_the_stated_time(self):
        # One coordinate: 0.85 kg, drives' friction, a torso of 1.8 kN/m that
        # is held 8 mm away from its rest.
        memory, now = armed()
        memory = memory._replace(command=(12.0,) * 6)
        memory = safety.stop(memory, Trip(Cause.STOP_KEY), now)
        y, v, times, path = 0.008, 0.0, [], []
        for i in range(1500):
            command = memory.command[0] - HOLD[0]
            force = 1.44 * command - 1800.0 * y - 6 * 20.0 * 0.2 * v
            v += 1e-3 * force / 0.85
            y += 1e-3 * v
            now += 1e-3
            legs = [length + 0.2 * (y - 0.008) for length in REST]
            memory = tick(memory, now, None, leg_length=legs)
            times.append(1e-3 * i)
            path.append(y)
        path = np.array(path)
        self.assertLess(abs(path[-1]), 2e-4)
        self.assertLess(np.abs(path[600:]).max(), 2e-3)
        # Soft: no faster than a hand's breadth per second.
        self.assertLess(np.abs(np.diff(path)).max() / 1e-3, 0.1)

    def test_rates_and_forces_are_cut_exactly(self):
        out = limit_command(DEFAULT, HOLD, (2.0, 8.0, -9.0, 2, 2, 2), 1e-3)
        self.assertEqual(out, (2.0, 7.0, -3.0, 2.0, 2.0, 2.0))


class _Brace(LeafSystem):
    """Readings and a command of a time, and what a supervisor made of it."""

    def __init__(self):
        super().__init__()
        for name, size, calc in (
            ("command", 6, lambda t: np.full(6, 2.0 + 5.0 * t)),
            ("length", 6, lambda t: np.array(REST)),
            ("force", 3, lambda t: np.array([0.0, 40.0 * t, 0.0])),
        ):
            self.DeclareVectorOutputPort(
                name,
                BasicVector(size),
                lambda c, o, f=calc: o.SetFromVector(f(c.get_time())),
            )


class TestSystem(unittest.TestCase):
    def simulate(self, until, request=None):
        builder = DiagramBuilder()
        brace = builder.AddSystem(_Brace())
        dut = builder.AddSystem(SafetySupervisor(DEFAULT, HOLD))
        for source, name in (
            ("command", "leg_command"),
            ("length", "leg_length"),
            ("force", "force"),
        ):
            builder.Connect(brace.GetOutputPort(source), dut.GetInputPort(name))
        if request is not None:
            source = builder.AddSystem(ConstantVectorSource([request]))
            builder.Connect(
                source.get_output_port(), dut.GetInputPort("request")
            )
        simulator = Simulator(builder.Build())
        simulator.AdvanceTo(until)
        context = dut.GetMyContextFromRoot(simulator.get_context())
        return (
            dut.GetOutputPort("leg_command").Eval(context),
            dut.GetOutputPort("status").Eval(context),
        )

    def test_it_passes_the_command_of_its_own_tick(self):
        command, status = self.simulate(0.5)
        np.testing.assert_allclose(command, 2.0 + 5.0 * 0.5, atol=1e-6)
        self.assertEqual(status[0], SafetyMode.ARMED)

    def test_it_stops_and_releases_as_the_state_machine_says(self):
        # 40 t N passes 50 N at 1.25 s; half a second later nothing is left.
        command, status = self.simulate(1.3)
        self.assertEqual(status[1], Cause.PAD_FORCE)
        self.assertAlmostEqual(status[3], 50.0, delta=0.05)
        left = remaining(0.049, DEFAULT.release_time)
        pressed = 2.0 + 5.0 * 1.25
        expected = 2.0 + left * (pressed - 2.0)
        np.testing.assert_allclose(command, expected, atol=0.05)
        command, _ = self.simulate(1.9)
        np.testing.assert_allclose(command, 2.0, atol=1e-6)

    def test_it_passes_nothing_before_it_is_armed(self):
        command, status = self.simulate(0.8, request=0.0)
        self.assertEqual(status[0], SafetyMode.RELEASED)
        np.testing.assert_allclose(command, 2.0, atol=1e-6)
        _, status = self.simulate(0.1, request=1.0)
        self.assertEqual(status[0], SafetyMode.ARMED)


if __name__ == "__main__":
    unittest.main()
