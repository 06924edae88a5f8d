"""The bench's instruments: leg encoders, force sensor, torso marker."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    EventStatus,
    LeafSystem,
)

from brace_drake.laws import blocks
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.hosting import EffectHost


class BenchInstruments(LeafSystem):
    """Readings at a tick: ideal value, effects, noise, rounding.

    Input ports:
        leg_length: True lengths (6,), m.
        pad_force: Force of the ring on the torso in W (3,), N.
        plant_state: Ring (13,), or ring and torso as the plant orders them.
        held_command: Commands held so far (6,), N.
        noise: Standard normal draws of the tick (12,); left unconnected the
            readings are exact and not rounded.

    Output ports:
        readings: Leg lengths (6), m, force (3), N, marker (3), m: (12,).

    Numeric parameters: resolution (2,), noise_sigma (12,); those of effects at
    `sensing`, whose states advance once in each tick.
    """

    def __init__(
        self,
        numbers: BenchNumbers,
        plug_ins: Mapping[str, PlugIn],
        with_torso: bool,
    ):
        super().__init__()
        self._period, self._rest = numbers.estimator[3], numbers.rest
        self._with_torso = with_torso
        self._ports = [
            self.DeclareVectorInputPort(name, size)
            for name, size in (
                ("leg_length", 6),
                ("pad_force", 3),
                ("plant_state", 26 if with_torso else 13),
                ("held_command", 6),
                ("noise", 12),
            )
        ]
        self._resolution, self._sigma = (
            int(self.DeclareNumericParameter(BasicVector(a)))
            for a in (numbers.resolution, numbers.noise_sigma)
        )
        self._host = EffectHost(
            self, plug_ins.get("sensing") or idle("sensing")
        )
        self._output = self.DeclareVectorOutputPort(
            "readings", 12, self._CalcReadings
        )
        if not self._host.is_idle:
            self.DeclarePeriodicUnrestrictedUpdateEvent(
                self._period, 0.0, self._Advance
            )
        self._ideal, self._readings = np.zeros(12), np.empty(12)
        self._no_noise = np.empty(0)

    def _Eval(self, context: Context):
        length, force, state, held, noise = self._ports
        ideal = self._ideal
        ideal[0:6] = length.Eval(context)
        ideal[6:9] = force.Eval(context)
        if self._with_torso:
            ideal[9:12] = state.Eval(context)[11:14] - self._rest
        draws = self._no_noise
        if noise.HasValue(context):
            sigma = context.get_numeric_parameter(self._sigma).CopyToVector()
            draws = noise.Eval(context) * sigma
        readings = self._readings
        readings[:] = ideal
        memory = self._host.memory(context)
        if not self._host.is_idle:
            self._host.apply(
                context,
                memory,
                context.get_time(),
                self._period,
                held.Eval(context).copy(),
                readings[0:6],
                readings[6:9],
            )
        resolution = context.get_numeric_parameter(self._resolution)
        blocks.read_instruments(resolution.CopyToVector(), draws, readings)
        return memory

    def _CalcReadings(self, context: Context, output: BasicVector) -> None:
        self._Eval(context)
        output.SetFromVector(self._readings)

    def _Advance(self, context: Context, state) -> EventStatus:
        memory = self._Eval(context)
        self._host.store(memory, state.get_mutable_discrete_state())
        return EventStatus.Succeeded()
