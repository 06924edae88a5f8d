"""Every fault of an emulated device ends where PROTOCOL.md says, in time."""

import math
import unittest
from dataclasses import replace

import numpy as np

from brace_drake.core.errors import LimitsError
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.laws.control import brace_control
from brace_drake.link.device.firmware import Firmware
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.operation.control import HostControl
from brace_drake.link.operation.session import Session
from brace_drake.link.protocol.limits import DEFAULT, shared_values
from brace_drake.link.protocol.words import Cause, DeviceState, Mode, Reason
from brace_drake.scenario.brace_numbers import pack_bench
from tests.link_bench import SCENARIO, Lockstep, begin, start

PERIOD_MS = 1
# Of a ring on its way, m/s.
_SPEED = 0.01


def ticks_until(bench, state, most=1000):
    """Ticks until the device is in a state; fails where it never is."""
    for i in range(most):
        if bench.firmware.state == state:
            return i
        bench.run(1)
    raise AssertionError(f"{bench.firmware.state!r} after {most} ticks")


class TestPlant(unittest.TestCase):
    def test_tick_by_tick_it_is_the_rollout_bit_by_bit(self):
        twin = BenchTwin(SCENARIO)
        nominal = np.array([p.nominal for p in twin.subject])
        motion = replace(
            twin.motion(MakeMotion("push_fast").run), ticks_per_sample=1
        )
        motion = replace(motion, desired=motion.desired[:2000])
        log = twin.simulate(motion, nominal)
        plant = BenchPlant(SCENARIO, seed=None)
        numbers = pack_bench(SCENARIO)
        memory = np.zeros((1, 6))
        held = brace_control.start_held(numbers.start, numbers.rest, memory)
        plant.u[:], u, X_d = 0.0, np.zeros(6), np.zeros((3, 6))
        for row, desired in zip(log, motion.desired, strict=True):
            readings = plant.advance(u)
            X_d[:, 1] = desired
            brace_control.advance_brace(
                brace_control.PIC, numbers.control, held, readings,
                X_d.ravel(), np.empty(0), u,
            )  # fmt: skip
            np.testing.assert_array_equal(readings, row[6:18])
            np.testing.assert_array_equal(u, row[:6])

    def test_the_weight_is_carried_at_rest(self):
        plant = BenchPlant(SCENARIO, seed=None)
        plant.with_torso = False
        for _ in range(500):
            readings = plant.advance(plant.hold).copy()
        first = BenchPlant(SCENARIO, seed=None).advance(plant.hold)
        np.testing.assert_allclose(readings[:6], first[:6], atol=1e-9)


class TestStates(unittest.TestCase):
    def test_hello_limits_arm_command_disarm_in_this_order(self):
        bench = Lockstep()
        self.assertEqual(bench.firmware.state, DeviceState.BOOT)
        bench.run(1)
        self.assertEqual(bench.firmware.state, DeviceState.HELLO)
        bench.Arm()
        self.assertEqual(bench.firmware.state, DeviceState.HELLO)
        echo = bench.agree()
        self.assertEqual(echo.reason, Reason.ACCEPTED)
        self.assertNotEqual(echo.session, 0)
        self.assertEqual(bench.firmware.state, DeviceState.DISARMED)
        bench.Arm()
        self.assertEqual(bench.firmware.state, DeviceState.ARMED)
        bench.Disarm()
        self.assertEqual(bench.firmware.state, DeviceState.DISARMED)

    def test_a_lost_request_to_disarm_is_no_stop(self):
        bench, session = start(seconds=0.2)
        while not session.done:
            bench.run(1)
        disarm = bench.Disarm

        def lose_the_first():
            # So long the link waits for an answer, and the watchdog less.
            self.assertLess(DEFAULT.watchdog, 0.2)
            bench.run(200)
            self.assertEqual(bench.firmware.state, DeviceState.ARMED)
            disarm()

        bench.Disarm = lose_the_first
        session.Finish()
        accepted = bench.firmware.accepted
        bench.run(100)
        self.assertEqual(bench.firmware.state, DeviceState.DISARMED)
        self.assertEqual(bench.firmware.trip.cause, Cause.NONE)
        self.assertIsNone(session.trip)
        self.assertEqual(bench.firmware.accepted, accepted)

    def test_a_reference_beyond_the_reach_never_arms(self):
        for y in (0.013, -0.0121, math.nan):
            bench = Lockstep()
            bench.agree()
            session = Session(bench, HostControl(SCENARIO), DEFAULT)
            desired = np.zeros((500, 3))
            desired[250, 0] = y
            with self.assertRaisesRegex(LimitsError, "allowed 12 mm"):
                session.Start(desired)
            bench.run(100)
            self.assertEqual(bench.firmware.state, DeviceState.DISARMED)

    def test_a_device_that_arms_and_sends_no_state_is_stopped(self):
        bench = Lockstep()
        bench.agree()
        # Long enough for a machine that others share.
        limits = DEFAULT._replace(stale=60.0)
        session = Session(bench, HostControl(SCENARIO), limits)
        session.Start(np.zeros((500, 3)))
        self.assertEqual(bench.firmware.state, DeviceState.ARMED)
        session.CheckAlive()
        self.assertFalse(session.is_over)
        session._last_arrival -= 61.0
        session.CheckAlive()
        self.assertEqual(session.trip.cause, Cause.STALE_DATA)
        self.assertEqual(bench.firmware.state, DeviceState.STOPPED)

    def test_nothing_but_a_sealed_arm_of_this_session_arms(self):
        bench = Lockstep()
        bench.agree()
        session, bench.session = bench.session, bench.session ^ 1
        bench.Arm()
        self.assertEqual(bench.firmware.state, DeviceState.DISARMED)
        bench.session = session
        bench.Send("CLEAR", {"cause": 0})
        bench.Send("COMMAND", {"mode": 0, "tick": 1, "values": (1.0,) * 6})
        bench.Send("HEARTBEAT", {"echo_us": 0})
        self.assertEqual(bench.firmware.state, DeviceState.DISARMED)
        self.assertEqual(bench.firmware.accepted, 0)

    def test_limits_wider_than_the_devices_are_refused_with_their_index(self):
        bench = Lockstep()
        echo = bench.agree(DEFAULT._replace(leg_speed=0.2))
        self.assertEqual(echo.reason, Reason.LIMIT_TOO_WIDE)
        self.assertEqual(echo.index, 4)
        self.assertEqual(bench.firmware.state, DeviceState.HELLO)
        self.assertEqual(bench.firmware.session, 0)

    def test_without_messages_the_session_ends_after_two_seconds(self):
        bench = Lockstep()
        bench.agree()
        n = ticks_until(bench, DeviceState.HELLO, 3000)
        self.assertAlmostEqual(n, 2000, delta=5)

    def test_a_stop_latches_until_it_is_cleared_by_its_cause(self):
        bench, session = start()
        bench.run(300)
        session.Stop(Cause.STOP_KEY)
        self.assertEqual(bench.firmware.state, DeviceState.STOPPED)
        for cause in (Cause.WATCHDOG, Cause.NONE):
            bench.Send("CLEAR", {"cause": cause})
        bench.Arm()
        self.assertEqual(bench.firmware.state, DeviceState.STOPPED)
        bench.Send("CLEAR", {"cause": Cause.STOP_KEY})
        self.assertEqual(bench.firmware.state, DeviceState.DISARMED)
        bench.Arm()
        self.assertEqual(bench.firmware.state, DeviceState.ARMED)


class TestCommands(unittest.TestCase):
    def setUp(self):
        self.bench = Lockstep()
        self.bench.agree()
        self.bench.Arm()
        self.bench.run(3)

    def send(self, values=(2.5,) * 6, tick=None, mode=Mode.FORCE):
        tick = self.bench.firmware.tick_count if tick is None else tick
        before = self.bench.firmware.accepted
        fields = {"mode": mode, "tick": tick, "values": values}
        self.bench.Send("COMMAND", fields)
        return self.bench.firmware.accepted - before

    def test_old_future_and_foreign_commands_are_refused(self):
        now = self.bench.firmware.tick_count
        self.assertEqual(self.send(), 1)
        self.assertEqual(self.send(tick=now + 1), 0)
        self.bench.run(20)
        self.assertEqual(self.send(), 1)
        for _ in range(3):
            self.bench.run(20)
            self.send()
        self.assertEqual(self.send(tick=now), 0)
        self.assertEqual(self.send(mode=Mode.LENGTH), 0)
        self.bench.session ^= 1
        self.assertEqual(self.send(), 0)

    def test_a_repeated_or_overtaken_command_is_refused(self):
        bench = self.bench
        for back in (1, 2, 1000):
            self.assertEqual(self.send(), 1)
            bench._sequence["h"] -= back
            self.assertEqual(self.send(), 0)
            bench._sequence["h"] += back

    def test_no_number_stops_and_too_much_is_cut(self):
        for _ in range(100):
            self.send((100.0, -100.0, 2.0, 2.0, 2.0, 2.0))
            u = self.bench.firmware.leg_force(self.bench.now)
        self.assertEqual(u[:2], (40.0, -40.0))
        self.assertEqual(self.send((math.nan,) * 6), 0)
        self.assertEqual(self.bench.firmware.state, DeviceState.STOPPED)
        self.assertEqual(self.bench.firmware.trip.cause, Cause.BAD_COMMAND)
        # Not a tick passed since; the next one tells.
        self.assertIsNone(self.bench.fault)
        self.bench.run(1)
        told = self.bench.fault.values
        self.assertEqual((told.state, told.cause), (4, Cause.BAD_COMMAND))


class TestFaults(unittest.TestCase):
    """The documented state, the documented time, after each fault."""

    def moving(self, **more):
        bench, session = start(**more)
        bench.run(900)
        self.assertEqual(bench.firmware.state, DeviceState.ARMED)
        self.assertIsNone(session.trip)
        return bench, session

    def assert_ends(self, bench, state, cause, ticks):
        took = ticks_until(bench, state, ticks + 5)
        self.assertLessEqual(took, ticks)
        self.assertEqual(bench.firmware.trip.cause, cause)
        return took

    def test_a_dead_host_within_the_watchdogs_period(self):
        for kill in range(5):
            bench, _ = self.moving(seed=kill)
            bench.run(kill)
            bench.host_is_dead = True
            took = self.assert_ends(
                bench, DeviceState.STOPPED, Cause.WATCHDOG, 51
            )
            self.assertGreaterEqual(took, 48)

    def test_heartbeats_alone_do_not_keep_it_armed(self):
        bench, _ = self.moving()
        bench.host_is_dead = True
        for i in range(60):
            bench.run(1)
            if i % 5 == 0:
                bench.Send("HEARTBEAT", {"echo_us": 0})
        self.assertEqual(bench.firmware.state, DeviceState.STOPPED)
        self.assertEqual(bench.firmware.trip.cause, Cause.WATCHDOG)

    def test_a_cut_line_either_way(self):
        for way in ("to_host", "to_device"):
            bench, _ = self.moving()
            getattr(bench, way).drop = 1.0
            self.assert_ends(bench, DeviceState.STOPPED, Cause.WATCHDOG, 51)

    def test_the_emergency_stop_within_a_tick_and_without_power(self):
        bench, session = self.moving()
        bench.estop = True
        self.assert_ends(bench, DeviceState.FAULT, Cause.ESTOP, 1)
        self.assertEqual(bench.firmware.leg_force(bench.now), (0.0,) * 6)
        bench.run(3)
        self.assertEqual(session.trip.cause, Cause.ESTOP)
        bench.Send("CLEAR", {"cause": Cause.ESTOP})
        self.assertEqual(bench.firmware.state, DeviceState.FAULT)
        bench.estop = False
        bench.run(2)
        bench.Send("CLEAR", {"cause": Cause.ESTOP})
        self.assertEqual(bench.firmware.state, DeviceState.DISARMED)

    def test_a_drives_fault_within_a_tick_and_without_power(self):
        bench, session = self.moving()
        bench.drive_fault = True
        self.assert_ends(bench, DeviceState.FAULT, Cause.DRIVE_FAULT, 1)
        self.assertEqual(bench.firmware.leg_force(bench.now), (0.0,) * 6)
        self.assertEqual(session.trip.cause, Cause.DRIVE_FAULT)
        for fault, state in ((True, "FAULT"), (False, "DISARMED")):
            bench.drive_fault = fault
            bench.run(2)
            bench.Send("CLEAR", {"cause": Cause.DRIVE_FAULT})
            self.assertEqual(bench.firmware.state.name, state)

    def crossing(self):
        """A ring without the torso, on its way along y at a steady speed."""
        plant = BenchPlant(SCENARIO)
        plant.with_torso = False
        bench = Lockstep(plant=plant)
        there = 5.5e-3 * (1.0 - np.cos(np.pi * np.arange(600) / 600.0))
        back = 11e-3 - _SPEED * 1e-3 * np.arange(2200)
        y = np.concatenate([there, back])
        rate = np.gradient(y, 1e-3)
        desired = np.column_stack([y, rate, np.zeros(len(y))])
        session = begin(bench, HostControl(SCENARIO), DEFAULT, desired)
        bench.run(1300)
        self.assertIsNone(session.trip)
        return bench, session

    def assert_trips(self, bench, session, cause, least, most):
        """The host's stop, between two times, s, and the device's with it."""
        begun = bench.tick
        while session.trip is None and bench.tick < begun + 3000:
            bench.run(1)
        self.assertEqual(session.trip.cause, cause)
        took = 1e-3 * (bench.tick - begun)
        self.assertGreaterEqual(took, least - 2e-3)
        self.assertLessEqual(took, most + 2e-3)
        self.assertEqual(bench.firmware.state, DeviceState.STOPPED)
        self.assertEqual(bench.firmware.trip.cause, cause)

    def test_a_frozen_reading_when_another_leg_has_gone_its_way(self):
        geometry = HostControl(SCENARIO)._geometry
        y = np.array([0.005, -0.005])
        lengths = [geometry.at(np.array([0, v, 0, 0, 0, 0]))[0] for v in y]
        speed = np.abs(lengths[1] - lengths[0]) / 0.01 * _SPEED
        for leg in (0, 2, 3):
            bench, session = self.crossing()
            bench.plant.frozen = {leg}
            once = DEFAULT.stuck_travel / np.delete(speed, leg).max()
            # The way there is not quite straight: 5 %.
            self.assert_trips(
                bench, session, Cause.STUCK_LEG, 0.95 * once, 2.1 * once
            )
            self.assertEqual(session.trip.index, leg)

    def test_readings_that_all_freeze_when_the_virtual_pose_has_gone_on(self):
        bench, session = self.crossing()
        bench.plant.frozen = set(range(6))
        control = session._control
        behind = abs(control.y_ring[0] - control.y_virtual[0])
        most = DEFAULT.tracking_position / _SPEED
        least = (DEFAULT.tracking_position - behind) / _SPEED
        self.assertGreater(least, 0.8 * most)
        self.assert_trips(bench, session, Cause.TRACKING, 0.97 * least, most)

    def test_a_jam_in_the_tick_in_which_the_ring_is_too_far_behind(self):
        bench, session = self.crossing()
        bench.plant.jammed = {0, 3}
        control, away = session._control, []

        def distance():
            ring = bench.plant.bodies[4:7] - bench.plant.numbers.rest[0]
            return np.linalg.norm(ring - control.virtual[0:3])

        while session.trip is None and len(away) < 2000:
            bench.run(1)
            away.append(distance())
        self.assertEqual(session.trip.cause, Cause.TRACKING)
        self.assertEqual(bench.firmware.state, DeviceState.STOPPED)
        self.assertEqual(bench.firmware.trip.cause, Cause.TRACKING)
        most = DEFAULT.tracking_position
        self.assertGreater(1e-3 * len(away), 0.8 * most / _SPEED)
        # The ring itself, not as it was measured: within 0.1 mm.
        self.assertAlmostEqual(away[-1], most, delta=1e-4)
        self.assertLess(max(away[:-20]), most)

    def test_a_ring_that_was_pushed_away_comes_home_before_it_moves(self):
        plant = BenchPlant(SCENARIO)
        plant.with_torso = False
        bench = Lockstep(plant=plant)
        bench.agree()
        bench.plant.bodies[4:7] += (0.003, -0.005, 0.002)
        bench.run(300)
        control = HostControl(SCENARIO)
        session = Session(bench, control, DEFAULT)
        session.Start(np.zeros((500, 3)), settle=1.0)
        bench.run(1400)
        self.assertIsNone(session.trip)
        away = bench.plant.bodies[4:7] - bench.plant.numbers.rest[0]
        self.assertLess(np.abs(away).max(), 1e-4)

    def test_a_force_beyond_its_limit_within_a_tick(self):
        tight = DEFAULT._replace(pad_force=8.0)
        bench, _ = start(limits=tight)
        for _ in range(2000):
            bench.run(1)
            if bench.firmware.state == DeviceState.STOPPED:
                break
        trip = bench.firmware.trip
        self.assertEqual(trip.cause, Cause.PAD_FORCE)
        self.assertAlmostEqual(trip.value, 8.0, delta=0.1)

    def test_a_bad_line_is_survived_and_counted(self):
        bench, session = self.moving()
        for way in (bench.to_host, bench.to_device):
            way.drop = way.corrupt = way.duplicate = way.reorder = 0.01
        bench.run(2000)
        self.assertEqual(bench.firmware.state, DeviceState.ARMED)
        self.assertIsNone(session.trip)
        tally = session.tally
        self.assertGreater(tally.bridged, 20)
        # Every tick of the motion is there, real or marked as bridged.
        ticks = [row.tick for row in session.rows]
        self.assertEqual(ticks, list(range(len(ticks))))
        marked = sum(row.bridged for row in session.rows)
        self.assertLessEqual(marked, bench.order.lost + bench.order.late)

    def test_a_slow_line_stops_nothing_but_shows(self):
        bench, session = self.moving()
        bench.to_device.delay = 0.003
        bench.run(2000)
        self.assertEqual(bench.firmware.state, DeviceState.ARMED)
        self.assertGreater(session.tally.ages.percentiles((50.0,))[0], 2)

    def test_after_a_stop_the_torso_pushes_the_ring_away(self):
        bench, session = self.moving()
        bench.run(300)
        pressed = bench.plant.bodies[5]
        session.Stop()
        limits = DEFAULT
        bench.run(round(1e3 * limits.release_time) + 1)
        np.testing.assert_allclose(
            bench.firmware.leg_force(bench.now), bench.plant.hold, atol=0.6
        )
        bench.run(1500)
        self.assertLess(abs(bench.plant.bodies[5]), 0.35 * abs(pressed))


class TestWatchdogAgainstTime(unittest.TestCase):
    def test_a_device_that_is_not_ticked_by_a_host_never_arms_itself(self):
        bench = Lockstep()
        bench.run(3000)
        self.assertEqual(set(bench.states), {DeviceState.HELLO})
        self.assertIsInstance(bench.firmware, Firmware)
        self.assertEqual(bench.firmware.own_limits, shared_values(DEFAULT))


if __name__ == "__main__":
    unittest.main()
