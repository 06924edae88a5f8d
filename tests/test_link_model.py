"""All short sequences of messages, and what no device may do after any."""

import unittest

from brace_drake.link.device.firmware import Firmware
from brace_drake.link.protocol.words import TRANSITIONS, DeviceState, Reason
from tools.check_link_model import ROOTS, run_long, search

# Actions behind each root, of which the longest has seven.
DEPTH = 3


class Trusting(Firmware):
    """Takes what is sealed, however often."""

    def _judge_order(self, packet):
        found = super()._judge_order(packet)
        is_old = found == Reason.REPLAYED
        return Reason.ACCEPTED if is_old else found


class Forgetful(Firmware):
    """Remembers only what it has accepted."""

    def receive(self, packet, now):
        mark, rejected = self._mark, self.rejected
        answers = super().receive(packet, now)
        if self.rejected > rejected:
            self._mark = mark
        return answers


class Sealless(Firmware):
    """Takes a frame of any session."""

    def _judge_order(self, packet):
        found = super()._judge_order(packet)
        is_foreign = found == Reason.WRONG_SESSION
        return Reason.ACCEPTED if is_foreign else found


class Boundless(Firmware):
    """Takes any limits."""

    def _judge_limits(self, packet, values):
        return Reason.ACCEPTED, 0


class Watchless(Firmware):
    """Stays armed without commands."""

    def tick(self, measured, now):
        self._fed = now
        return super().tick(measured, now)


class Reckless(Firmware):
    """Does not look at its emergency stop."""

    def tick(self, measured, now):
        return super().tick(measured._replace(estop=False), now)


class Stiff(Firmware):
    """Holds its last command after a stop."""

    def leg_force(self, now):
        held = self._command
        u = super().leg_force(now)
        return held if self.state == DeviceState.STOPPED else u


class TestModel(unittest.TestCase):
    def test_no_short_sequence_breaks_what_the_protocol_says(self):
        seen, worlds = set(), 0
        for root in ROOTS:
            found = search(DEPTH, root)
            self.assertEqual(found.broken, "")
            seen |= found.seen
            worlds += found.worlds
        self.assertEqual(seen, set(TRANSITIONS))
        self.assertGreater(worlds, 20_000)

    def test_no_frame_that_comes_again_arms(self):
        counts = run_long(20_000, 1)
        self.assertGreater(counts["again"], 5_000)
        self.assertGreater(counts["armings"], 20)
        self.assertEqual(counts["armings without a fresh ARM"], 0)

    def test_a_device_that_does_otherwise_is_found(self):
        for firmware, words in (
            (Trusting, "not fresh"),
            (Forgetful, "not fresh"),
            (Sealless, "not fresh"),
            (Boundless, "limits too wide"),
            (Watchless, "beyond the watchdog"),
            (Reckless, "e-stop"),
            (Stiff, "force but release damping"),
        ):
            with self.subTest(firmware=firmware.__name__):
                found = (search(DEPTH, root, firmware) for root in ROOTS)
                broken = next(f.broken for f in found if f.broken)
                self.assertIn(words, broken)


if __name__ == "__main__":
    unittest.main()
