"""The host's side of the link: hello, limits, states, commands."""

from __future__ import annotations

import math
import random
import threading
import time
from collections.abc import Callable, Sequence

import serial

from brace_drake.core.errors import LimitsError, LinkError
from brace_drake.link.host.inbox import Inbox
from brace_drake.link.host.ports import (
    OpenPort,
    describe_stranger,
    gone,
    write_frame,
)
from brace_drake.link.protocol.codec import Decoder, Packet, make_codec
from brace_drake.link.protocol.limits import (
    SHARED,
    Limits,
    refuse_other,
    refuse_wider,
    shared_of,
    shared_values,
)
from brace_drake.link.protocol.messages import BAUD, BY_NAME
from brace_drake.link.protocol.sequence import Counts, SequenceWatch
from brace_drake.link.protocol.words import (
    Cause,
    DeviceState,
    Mode,
    Reason,
    reason_text,
)

_AGAIN, _HEARTBEAT = 0.2, 0.1
# Longer than a session lasts whose host has gone, s.
_SESSION_ENDS = 3.0
_REACHED = {"ARM": DeviceState.ARMED, "CLEAR": DeviceState.DISARMED}


class Link:
    """A connection to one device.

    States are handed to `on_state` in the thread that reads, so that an answer
    leaves without waiting for another thread. Every other method may be called
    from any thread.

    Attributes:
        path: The port.
        hello, geometry, device_limits: What the device said of itself.
        session: Number of the session, 0 before `agree`.
        round_trip: The shortest from a heartbeat to its echo, s; endless
            before the first.
    """

    def __init__(self, path: str, baud: int = BAUD):
        self.path = path
        self.hello = self.geometry = self.device_limits = None
        self.session, self.round_trip = 0, math.inf
        self.on_state: Callable[[Packet, int], None] | None = None
        self._port, self._codec = OpenPort(path, baud), make_codec(1)
        self._decoder = Decoder(self._codec, follows_hello=True)
        self._sequence = random.randrange(2**16)
        self._order, self._messages, self._states = SequenceWatch(), 0, 0
        self._sending, self._inbox = threading.Lock(), Inbox()
        self._closed, self._beat, self._echoes_due = threading.Event(), 0.0, 0
        self._reader = threading.Thread(
            target=self._Read, name=f"link {path}", daemon=True
        )
        self._reader.start()

    # Conversation

    def Connect(self, timeout: float = 3.0) -> None:
        """Asks who is there until the device has said all of itself.

        Raises:
            LinkError: Nobody, a stranger, or a device of another protocol.
        """
        ends, nonce = time.monotonic() + timeout, random.randrange(2**32)
        names = ("HELLO", "GEOMETRY", "DEVICE_LIMITS")
        self._decoder.follows_hello = True
        self._inbox.Forget(*names)
        while time.monotonic() < ends:
            self.Send("HELLO_REQUEST", {"nonce": nonce})
            if self._inbox.WaitFor(names, _AGAIN):
                hello, geometry, limits = (self._inbox[n] for n in names)
                if hello.values.nonce == nonce:
                    self.hello, self.geometry = hello.values, geometry.values
                    self.device_limits = shared_of(limits.values)
                    self._codec = make_codec(self.hello.stages)
                    self._decoder.follows_hello = False
                    return
                self._inbox.Forget(*names)  # For somebody before us.
            self._CheckAlive()
        raise LinkError(f"{self.path}: {describe_stranger(self._decoder)}")

    def Agree(self, limits: Limits) -> None:
        """Tells the limits and begins a session.

        Raises:
            LimitsError: They are wider than the device's own, what it echoes
                is not what it was told, or another host has it.
            LinkError: No answer.
        """
        stages = self.hello.stages
        refuse_wider(limits, self.device_limits, stages)
        asked = shared_values(limits, stages)
        ends = time.monotonic() + _SESSION_ENDS
        echo = self._Ask("LIMITS", asked, "LIMITS_ECHO").values
        while echo.reason == Reason.REPLAYED and time.monotonic() < ends:
            # A host was here before us: its numbers are ahead of ours, which
            # half a turn mends, or its clock is, which takes until it is over.
            self._sequence ^= 0x8000
            time.sleep(_AGAIN)
            echo = self._Ask("LIMITS", asked, "LIMITS_ECHO").values
        if echo.reason != Reason.ACCEPTED:
            name = SHARED[min(echo.index, len(SHARED) - 1)].name
            at = "" if echo.reason == Reason.REPLAYED else f" at {name}"
            raise LimitsError(
                f"{self.path}: the device refuses the limits{at}:"
                f" {reason_text(echo.reason)}"
            )
        refuse_other(asked, shared_of(echo))

    def Arm(self) -> None:
        """Lets the drives follow commands.

        Raises:
            LinkError: The device refuses; the message says why.
        """
        self._Request("ARM", {"nonce": random.randrange(2**32)})

    def Disarm(self) -> None:
        """Releases the drives without a latched stop."""
        self._Request("DISARM", {"nonce": random.randrange(2**32)})

    def Stop(self, cause: Cause = Cause.HOST_STOP) -> None:
        """Releases the drives and latches; asks again until it is answered."""
        self._Request("STOP", {"cause": int(cause)})

    def Clear(self, cause: Cause) -> None:
        """Ends a latched stop."""
        self._Request("CLEAR", {"cause": int(cause)})

    def WaitForState(self, timeout: float = 1.0):
        """Fields of the next state.

        Raises:
            LinkError: None comes.
        """
        self._inbox.Forget("STATE")
        if not self._inbox.WaitFor(("STATE",), timeout):
            self._CheckAlive()
            raise LinkError(f"{self.path}: the device sends no states")
        return self._inbox["STATE"].values

    def Command(
        self, values: Sequence[float], tick: int, mode: Mode = Mode.FORCE
    ) -> int:
        """Sends leg forces (6 S,), N, in answer to the state of a tick.

        Args:
            values: With the mode LENGTH, leg lengths, m.
            tick: Of the state.
            mode: One from arming to disarming; LENGTH where the device's
                `capabilities` say so.

        Returns:
            The sequence that the device will show as in use.
        """
        told = {"mode": mode, "tick": tick, "values": values}
        return self.Send("COMMAND", told)

    def Send(self, name: str, values: dict) -> int:
        """Sends a message; returns its sequence.

        Raises:
            LinkError: The port is gone.
        """
        session = 0 if name == "LIMITS" else self.session
        self._echoes_due += name == "LIMITS"
        with self._sending:
            sequence = self._sequence = (self._sequence + 1) & 0xFFFF
            stamp = time.perf_counter_ns() // 1000
            frame = self._codec.encode(name, values, sequence, stamp, session)
            write_frame(self._port, self.path, frame)
        return sequence

    @property
    def counts(self) -> Counts:
        """What has come in so far."""
        order, decoder = self._order, self._decoder
        return Counts(
            self._messages, self._states, decoder.num_bad, order.lost,
            order.repeated, order.late, decoder.bytes_read,
        )  # fmt: skip

    @property
    def fault(self) -> Packet | None:
        """The last fault that the device has told."""
        return self._inbox.fault

    @property
    def error(self) -> Exception | None:
        """What ended the reading, None while it goes on."""
        return self._inbox.error

    def Close(self) -> None:
        """Ends the reading and closes the port; not from the reading thread."""
        self._closed.set()
        self._reader.join(1.0)
        self._port.close()

    def __enter__(self) -> Link:
        return self

    def __exit__(self, *_) -> None:
        self.Close()

    # Answers

    def _Ask(self, name: str, values: dict, answer: str, tries: int = 5):
        self._inbox.Forget(answer)
        asked: list[int] = []
        for _ in range(tries):
            asked.append(self.Send(name, values))
            if self._inbox.WaitFor((answer,), _AGAIN, asked):
                return self._inbox[answer]
            self._CheckAlive()
        raise LinkError(f"{self.path}: no answer to {name.lower()}")

    def _Request(self, name: str, values: dict) -> None:
        session = self.session
        answer = self._Ask(name, values, "ANSWER").values
        if self.session != session:
            answer = self._Ask(name, values, "ANSWER").values
        # A device that was asked twice refuses what it has done.
        done = answer.state == _REACHED.get(name)
        if answer.reason != Reason.ACCEPTED and not done:
            raise LinkError(
                f"{self.path}: the device refuses to {name.lower()}:"
                f" {reason_text(answer.reason)}"
            )

    def _CheckAlive(self) -> None:
        if self.error is not None:
            raise gone(self.path, self.error)

    # Reading

    def _Read(self) -> None:
        try:
            while not self._closed.is_set():
                data = self._port.read(max(1, self._port.in_waiting))
                self._Accept(data, now := time.perf_counter_ns())
                if self.session and now - self._beat > _HEARTBEAT * 1e9:
                    self._beat = now
                    self.Send("HEARTBEAT", {"echo_us": 0})
        except (OSError, TypeError, serial.SerialException, LinkError) as error:
            if not self._closed.is_set():
                self._inbox.End(gone(self.path, error))
        except Exception as error:  # A handler's own: told where it is waited.
            self._inbox.End(error)

    def _Accept(self, data: bytes, now: int) -> None:
        """Takes bytes that have come at a time, ns."""
        for packet in self._decoder.feed(data):
            # Only who was asked for a hello may begin anew with it.
            begins = packet.name == "HELLO" and self._decoder.follows_hello
            lost = self._order.take(packet.sequence, begins)
            if lost is not None:
                self._Take(packet, lost, now)

    def _Take(self, packet: Packet, lost: int, now: int) -> None:
        if BY_NAME[packet.name].sender == "host":
            return
        self._messages += 1
        if packet.name == "STATE":
            self._states += 1
            if self.on_state is not None:
                self.on_state(packet, lost)
            else:
                self._inbox.Put(packet)
        elif packet.name == "LIMITS_ECHO" and self._echoes_due:
            # Limits that were told twice have begun a second session.
            self._echoes_due -= 1
            self.session = packet.values.session or self.session
            self._inbox.Put(packet)
        elif packet.name == "HEARTBEAT":
            trip = 1e-9 * now - 1e-6 * packet.values.echo_us
            if trip >= 0.0:
                self.round_trip = min(self.round_trip, trip)
        else:
            self._inbox.Put(packet)
