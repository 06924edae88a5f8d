"""What a line repeats, holds back or cuts off must neither arm nor void."""

import io
import math
import tempfile
import unittest
from unittest import mock

import numpy as np

from brace_drake.cli.machine.emulate import _Obey
from brace_drake.core.errors import LimitsError
from brace_drake.link.device.limits_file import check_limits
from brace_drake.link.emulator.line import Line, LineFaults
from brace_drake.link.host.link import Link
from brace_drake.link.operation.control import HostControl
from brace_drake.link.operation.session import Session
from brace_drake.link.protocol.codec import longest_frame, make_codec
from brace_drake.link.protocol.limits import (
    DEFAULT,
    LIMITS,
    SHARED,
    shared_values,
)
from brace_drake.link.protocol.sequence import steps_ahead
from brace_drake.link.protocol.words import Cause, DeviceState, Reason
from tests.emulated_devices import SCENARIO, emulated, wait_for
from tests.link_bench import Lockstep, start


class Tapped(Lockstep):
    """A bench whose frames from the host are kept, to be sent again."""

    def __init__(self, **more):
        self.kept = []
        super().__init__(**more)
        send = self._in.send

        def keep(frame, now):
            self.kept.append(frame)
            send(frame, now)

        self._in.send = keep

    def last(self, name):
        """The newest frame of this name."""
        return next(
            f
            for f in reversed(self.kept)
            if make_codec(1).decode(f[1:-1]).name == name
        )

    def again(self, frame):
        """Hands old bytes to the device; its answer's reason."""
        self.run(1)
        self.heard.clear()
        self._in.send(frame, self.now)
        self.kept.pop()
        self._deliver()
        self.run(1)
        return [p.values.reason for p in self.heard if p.name != "STATE"]


class SlowClock:
    """The codec of a host whose clock began after another's."""

    def encode(self, name, values, sequence, time_us, session):
        behind = max(0, time_us - 10**9)
        return make_codec(1).encode(name, values, sequence, behind, session)


class TestReplay(unittest.TestCase):
    def setUp(self):
        self.bench = Tapped()
        self.bench.agree()
        self.bench.run(1)

    def state(self):
        return self.bench.firmware.state

    def test_an_arm_that_is_repeated_does_not_arm(self):
        bench = self.bench
        bench.Arm()
        arm = bench.last("ARM")
        bench.run(3)
        bench.Disarm()
        self.assertEqual(bench.again(arm), [Reason.REPLAYED])
        self.assertEqual(self.state(), DeviceState.DISARMED)
        bench.run(1)
        bench.Arm()
        self.assertEqual(self.state(), DeviceState.ARMED)

    def test_an_arm_that_was_overtaken_does_not_arm(self):
        bench = self.bench
        for end in ("DISARM", "STOP"):
            bench._in.faults.drop = 1.0
            bench.Arm()
            bench._in.faults.drop = 0.0
            arm = bench.last("ARM")
            bench.run(1)
            if end == "DISARM":
                bench.Disarm()
            else:
                bench.Send("STOP", {"cause": Cause.STOP_KEY})
                bench.Send("CLEAR", {"cause": Cause.STOP_KEY})
            self.assertEqual(self.state(), DeviceState.DISARMED)
            self.assertEqual(bench.again(arm), [Reason.REPLAYED])
            self.assertEqual(self.state(), DeviceState.DISARMED)

    def test_arm_and_clear_that_are_repeated_in_a_loop_never_arm(self):
        bench = self.bench
        bench.Arm()
        bench.Send("STOP", {"cause": Cause.STOP_KEY})
        bench.Send("CLEAR", {"cause": Cause.STOP_KEY})
        bench.Send("STOP", {"cause": Cause.STOP_KEY})
        old = [bench.last(name) for name in ("CLEAR", "ARM")]
        for i in range(100):
            bench.again(old[i % 2])
            self.assertEqual(self.state(), DeviceState.STOPPED)

    def test_no_repeat_passes_when_numbers_have_gone_round(self):
        bench = self.bench
        bench.Arm()
        arm, number = bench.last("ARM"), bench._sequence["h"]
        bench.Disarm()
        for turned in (0x4000, 0x7FFF, 0x8000, 0x9000, 0xFFFF, 0x10000):
            # So long it takes at 1 kHz; heartbeats keep the session.
            bench.tick += 0x8000
            bench.now = bench.firmware._heard = bench.tick * 1e-3
            bench._sequence["h"] = number + turned
            bench.Arm()
            self.assertEqual(self.state(), DeviceState.ARMED)
            bench.Disarm()
            self.assertEqual(bench.again(arm), [Reason.REPLAYED])
            self.assertEqual(self.state(), DeviceState.DISARMED)

    def test_limits_that_are_repeated_leave_the_session(self):
        bench = self.bench
        limits, session = bench.last("LIMITS"), bench.firmware.session
        self.assertEqual(bench.again(limits), [Reason.REPLAYED])
        bench.Arm()
        self.assertEqual(self.state(), DeviceState.ARMED)
        bench.Send("STOP", {"cause": Cause.STOP_KEY})
        self.assertEqual(bench.again(limits), [Reason.REPLAYED])
        self.assertEqual(bench.firmware.session, session)
        # New ones are welcome.
        bench.heard.clear()
        self.assertNotIn(bench.agree().session, (0, session))

    def test_a_repeated_message_does_not_keep_a_session(self):
        bench = self.bench
        for _ in range(30):
            bench.again(bench.last("LIMITS"))
            bench.run(100)
        self.assertIn(DeviceState.HELLO, bench.states)

    def test_a_host_after_a_host_waits_for_the_session_at_most(self):
        with emulated() as device:
            for codec in (make_codec(1), make_codec(1), SlowClock()):
                with Link(device.terminal.path) as link:
                    link.Connect(20.0)
                    link._codec = codec
                    link.Agree(DEFAULT)
                    self.assertEqual(link.session, device.firmware.session)


class TestFaultThatStays(unittest.TestCase):
    def test_a_host_that_comes_later_can_clear_it(self):
        bench = Lockstep()
        bench.agree()
        bench.estop = True
        bench.run(2100)
        self.assertEqual(bench.firmware.session, 0)
        bench.estop = False
        bench.heard.clear()
        bench.agree()
        self.assertEqual(bench.firmware.state, DeviceState.FAULT)
        bench.Send("CLEAR", {"cause": Cause.ESTOP})
        self.assertEqual(bench.firmware.state, DeviceState.DISARMED)

    def test_no_command_of_before_it_is_left(self):
        bench = Lockstep()
        bench.agree()
        bench.Arm()
        bench.run(1)
        values = tuple(force + 1.0 for force in bench.plant.hold)
        for _ in range(5):
            bench.Command(values, bench.firmware.tick_count)
            bench.run(1)
        bench.estop = True
        bench.run(2)
        bench.estop = False
        bench.run(1)
        bench.Send("CLEAR", {"cause": Cause.ESTOP})
        bench.Arm()
        held = bench.firmware.leg_force(bench.now)
        self.assertEqual(bench.firmware.state, DeviceState.ARMED)
        self.assertEqual(held, bench.plant.hold)


class TestLateAnswers(unittest.TestCase):
    def test_what_was_asked_twice_is_done_once(self):
        with emulated() as device, Link(device.terminal.path) as link:
            link.Connect(20.0)
            # Longer than a host waits before it asks again.
            device.faults.to_host.delay = 0.3
            link.Agree(DEFAULT)
            link.Arm()
            self.assertEqual(device.firmware.state, DeviceState.ARMED)
            link.Disarm()
            link.Stop()
            link.Clear(Cause.HOST_STOP)
            self.assertEqual(device.firmware.state, DeviceState.DISARMED)
            self.assertEqual(link.session, device.firmware.session)


class TestBounds(unittest.TestCase):
    def test_the_device_refuses_what_is_out_of_bounds(self):
        for i, limit in enumerate(SHARED):
            for value in (1.01 * limit.most, 0.99 * limit.least, math.nan):
                bench = Lockstep()
                # A device that allows all.
                own = {s.name: getattr(s, s.side) for s in SHARED}
                wide = DEFAULT._replace(**own)
                bench.firmware.own_limits = shared_values(wide)
                echo = bench.agree(DEFAULT._replace(**{limit.name: value}))
                self.assertEqual(echo.reason, Reason.BAD_VALUE, limit.name)
                self.assertEqual(echo.index, i)
                self.assertEqual(bench.firmware.session, 0)

    def test_legs_that_may_have_no_length_are_refused(self):
        bench = Lockstep()
        echo = bench.agree(DEFAULT._replace(leg_shortest=0.166))
        self.assertEqual((echo.reason, echo.index), (Reason.BAD_VALUE, 3))

    def test_host_and_device_refuse_bounds_of_their_own_limits(self):
        damped = DEFAULT._replace(release_damping=20000.0)
        with self.assertRaisesRegex(LimitsError, "release_damping.*1 to 100"):
            check_limits(damped)
        with self.assertRaisesRegex(LimitsError, "of the device: release_da"):
            Lockstep(damped)
        for limit in LIMITS:
            self.assertTrue(limit.allows(limit.default))
            with self.assertRaisesRegex(LimitsError, limit.name):
                check_limits(DEFAULT._replace(**{limit.name: 2 * limit.most}))


class TestEnds(unittest.TestCase):
    """A host in mid-motion ends with its cause, whatever it sees."""

    def moving(self):
        bench, session = start()
        bench.run(600)
        self.assertIsNone(session.trip)
        return bench, session

    def test_a_foreign_disarm_within_a_tick(self):
        bench, session = self.moving()
        bench.Disarm()
        bench.run(1)
        self.assertEqual(session.trip.cause, Cause.DISARMED)
        self.assertIn("left ARMED", session.stopped_by)
        self.assertTrue(session.is_over)
        self.assertEqual(bench.firmware.state, DeviceState.STOPPED)

    def test_a_device_in_any_other_state_within_a_tick(self):
        for state in (0, 1, 2, 6, 255):
            bench, session = self.moving()
            describe = bench.firmware._describe
            bench.firmware._describe = lambda d=describe, s=state: (
                d() | {"state": s}
            )
            bench.run(1)
            self.assertEqual(session.trip.cause, Cause.DISARMED)

    def test_a_foreign_disarm_ends_a_recording(self):
        with emulated() as device, Link(device.terminal.path) as link:
            link.Connect(20.0)
            link.Agree(DEFAULT)
            limits = DEFAULT._replace(stale=5.0, lost_messages=1000.0)
            session = Session(link, HostControl(SCENARIO), limits)

            def disarm(_):
                if session.tally.ticks > 50:
                    link.Send("DISARM", {"nonce": 0})

            session.Follow(np.zeros((60_000, 3)), disarm)
            self.assertEqual(session.trip.cause, Cause.DISARMED)
            self.assertTrue(
                wait_for(lambda: device.firmware.state == DeviceState.STOPPED)
            )

    def test_a_device_that_begins_anew_is_silent_and_told(self):
        bench, session = self.moving()
        session._setup = session._setup._replace(
            limits=DEFAULT._replace(stale=0.05)
        )
        bench.firmware.session, bench.firmware.state = 0, DeviceState.HELLO
        bench.run(1)
        self.assertTrue(wait_for(lambda: session.CheckAlive() or session.trip))
        self.assertEqual(session.trip.cause, Cause.STALE_DATA)


class TestTicks(unittest.TestCase):
    def test_serial_numbers(self):
        for a, b, ahead in ((3, 1, 2), (1, 3, -2), (0, 2**32 - 1, 1)):
            self.assertEqual(steps_ahead(a, b, 32), ahead)
        self.assertEqual(steps_ahead(0x8000, 0), -0x8000)
        self.assertEqual(steps_ahead(5, 0xFFFE), 7)

    def test_a_motion_goes_on_over_the_end_of_the_ticks(self):
        bench = Lockstep()
        bench.firmware.tick_count = 2**32 - 700
        bench.agree()
        session = Session(bench, HostControl(SCENARIO), DEFAULT)
        session.Start(np.zeros((1000, 3)), settle=0.4)
        bench.run(1600)
        self.assertIsNone(session.trip)
        self.assertTrue(session.done)
        self.assertEqual(session.tally.bridged, 0)
        self.assertLess(bench.firmware.tick_count, 1000)
        self.assertLessEqual(session.tally.ages.largest, 2)


class TestFloods(unittest.TestCase):
    def test_a_flood_without_delimiter_takes_no_room(self):
        with emulated() as device:
            for _ in range(50):
                device._Take(b"\x07" * 50_000)
            self.assertLessEqual(len(device._rest), longest_frame())
            self.assertLess(len(device._decoder._rest), 2 * longest_frame())

    def test_a_line_that_is_full_loses_frames(self):
        line = Line(LineFaults(delay=10.0))
        for _ in range(30_000):
            line.send(b"\0x\0", 0.0)
        self.assertLessEqual(len(line._queue), 20_000)


class TestControlInput(unittest.TestCase):
    def test_no_line_ends_the_input(self):
        lines = (
            b'estop "on\n', b"\xff\xfe\x00\n", b"noise 99999999999999\n",
            b"noise " + b"9" * 6000 + b"\n", b"to-host drop nan\n",
            b"to-host __class__ 1\n", b"stuck -1\n", b"\\\n", b"drive on\n",
        )  # fmt: skip
        with emulated() as device, tempfile.TemporaryFile() as given:
            given.write(b"".join(lines))
            given.seek(0)
            told = io.StringIO()
            with (
                mock.patch("sys.stdin", given),
                mock.patch("sys.stderr", told),
            ):
                _Obey(device)
            self.assertTrue(device.faults.drive_fault)
            self.assertFalse(device.faults.estop)
            self.assertIn("No closing quotation", told.getvalue())


if __name__ == "__main__":
    unittest.main()
