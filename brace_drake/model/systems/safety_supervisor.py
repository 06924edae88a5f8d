"""The safety supervisor of `brace_drake.link` as a system."""

from __future__ import annotations

from collections.abc import Sequence

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.link.device import safety
from brace_drake.link.device.guards import Trip
from brace_drake.link.device.safety_memory import (
    Memory,
    Reading,
    Setup,
    start_memory,
)
from brace_drake.link.protocol.limits import Limits
from brace_drake.link.protocol.words import Cause
from brace_drake.model.systems.ticks import TICK_LEAD

# Of `status`: mode, cause, index, value, limit, whether a command was cut.
NUM_STATUS = 6


class SafetySupervisor(LeafSystem):
    """Passes leg commands within limits, or releases the rings and latches.

    The state machine and its laws are `link.device.safety`, those that guard a
    physical brace. It ticks between the controller's tick and the plant's step,
    so that a command that passes acts from its own tick on.

    Input ports:
        leg_command: Asked for (n,), N.
        leg_length: Measured (n,), m.
        force: Of each ring on the torso, W (n / 2,), N.
        pose: X of each ring (n,); may be left unconnected.
        virtual_pose: X_v of each ring (n,); may be left unconnected.
        expected_force: What the legs leave for the torso (n / 2,), N, that
            `force` may not be far from; may be left unconnected.
        reading_time: When the readings were taken (1,), s; unconnected: now.
        request: 1 arms (from RELEASED), 2 disarms, 3 stops, 4 clears (1,); acts
            when it changes. Unconnected: armed from the start.

    Output ports:
        leg_command: What the legs shall do (n,), N, held from the last tick;
            before the first tick the input, as the controller has it.
        status: See NUM_STATUS.

    Its memory (`Memory`) is an abstract state of the Context.
    """

    def __init__(
        self, limits: Limits, hold: Sequence[float], period: float = 1e-3
    ):
        super().__init__()
        self._setup = Setup(limits, tuple(map(float, hold)), period)
        n = len(self._setup.hold)
        declare = self.DeclareVectorInputPort
        self._command_port = declare("leg_command", n)
        self._length_port = declare("leg_length", n)
        self._force_port = declare("force", n // 2)
        self._pose_port = declare("pose", n)
        self._virtual_port = declare("virtual_pose", n)
        self._expected_port = declare("expected_force", n // 2)
        self._time_port = declare("reading_time", 1)
        self._request_port = declare("request", 1)
        start = start_memory(self._setup)
        self._memory = int(
            self.DeclareAbstractState(AbstractValue.Make((start, 0.0, False)))
        )
        for name, size, calc, ports in (
            ("leg_command", n, self._CalcCommand, [self._command_port]),
            ("status", NUM_STATUS, self._CalcStatus, []),
        ):
            # Else what sees a command that passed could not be an input.
            tickets = {self.input_port_ticket(p.get_index()) for p in ports}
            tickets.add(self.all_state_ticket())
            self.DeclareVectorOutputPort(name, BasicVector(size), calc, tickets)
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            period, period - TICK_LEAD / 2.0, self._Tick
        )

    def memory(self, context: Context) -> Memory:
        """What the supervisor remembers."""
        return self._Load(context)[0]

    def _Load(self, context: Context):
        return context.get_abstract_state(self._memory).get_value()

    def _Tick(self, context: Context, state) -> None:
        memory, request, started = self._Load(context)
        now, reading = context.get_time(), self._Read(context)
        asked = self._command_port.Eval(context)
        if not started:
            # What is held now is what the controller has held so far.
            held = Reading(reading.time, *reading[1:3])
            memory = safety.advance(self._setup, memory, now, held, None)
            memory = memory._replace(command=tuple(asked))
            if not self._request_port.HasValue(context):
                memory = safety.arm(memory)
        if self._request_port.HasValue(context):
            wanted = float(self._request_port.Eval(context)[0])
            if wanted != request:
                memory = _carry_out(wanted, memory, now)
            request = wanted
        memory = safety.advance(self._setup, memory, now, reading, asked)
        value = AbstractValue.Make((memory, request, True))
        state.get_mutable_abstract_state(self._memory).SetFrom(value)

    def _Read(self, context: Context) -> Reading:
        def optional(port):
            return port.Eval(context) if port.HasValue(context) else None

        measured = optional(self._time_port)
        now = context.get_time()
        return Reading(
            now if measured is None else float(measured[0]),
            self._length_port.Eval(context).tolist(),
            self._force_port.Eval(context).tolist(),
            pose=optional(self._pose_port),
            virtual=optional(self._virtual_port),
            expected=optional(self._expected_port),
        )

    def _CalcCommand(self, context: Context, output: BasicVector) -> None:
        memory, _, started = self._Load(context)
        if started:
            output.SetFromVector(memory.command)
        else:
            output.SetFromVector(self._command_port.Eval(context))

    def _CalcStatus(self, context: Context, output: BasicVector) -> None:
        memory = self._Load(context)[0]
        trip = memory.trip
        output.SetFromVector(
            [
                memory.mode,
                trip.cause,
                trip.index,
                trip.value,
                trip.limit,
                memory.clamped,
            ]
        )


def _carry_out(request: float, memory: Memory, now: float) -> Memory:
    if request == 1.0:
        return safety.arm(memory)
    if request == 2.0:
        return safety.disarm(memory, now)
    if request == 3.0:
        return safety.stop(memory, Trip(Cause.HOST_STOP), now)
    if request == 4.0:
        return safety.clear(memory)
    return memory
