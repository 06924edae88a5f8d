"""The bench's instruments: leg encoders, force sensor, torso marker."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws import blocks
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.hosting import EffectHost
from brace_drake.systems.ticks import DeclareTick


class BenchInstruments(LeafSystem):
    """Readings at a tick: ideal value, effects, noise, rounding.

    Input ports:
        measured: True leg lengths (6), m, force of the ring on the torso (3),
            N, displacement of the torso (3), m: (12,).
        held_command: Commands of the last tick (6,), N.
        noise: Standard normal draws of the tick (12,); left unconnected the
            readings are exact and not rounded.

    Output ports:
        readings: Leg lengths (6), m, force (3), N, marker (3), m: (12,).

    Numeric parameters: resolution (2,), noise_sigma (12,); those of effects at
    `sensing`, whose states advance once in each tick.
    """

    def __init__(self, numbers: BenchNumbers, plug_ins: Mapping[str, PlugIn]):
        super().__init__()
        self._period = numbers.estimator[3]
        self._measured_port, self._held_port, self._noise_port = (
            self.DeclareVectorInputPort(name, size)
            for name, size in (
                ("measured", 12),
                ("held_command", 6),
                ("noise", 12),
            )
        )
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
            DeclareTick(self, self._period, self._Advance)
        self._readings = np.empty(12)

    def _Eval(self, context: Context):
        readings = self._readings
        readings[:] = self._measured_port.Eval(context)
        memory = self._host.memory(context)
        if not self._host.is_idle:
            self._host.apply(
                context,
                memory,
                context.get_time(),
                self._period,
                self._held_port.Eval(context),
                readings[0:6],
                readings[6:9],
            )
        if self._noise_port.HasValue(context):
            resolution = context.get_numeric_parameter(self._resolution)
            sigma = context.get_numeric_parameter(self._sigma)
            noise = self._noise_port.Eval(context) * sigma.value()
            blocks.read_instruments(resolution.value(), noise, readings)
        return memory

    def _CalcReadings(self, context: Context, output: BasicVector) -> None:
        self._Eval(context)
        output.SetFromVector(self._readings)

    def _Advance(self, context: Context, discrete) -> None:
        self._host.store(self._Eval(context), discrete)
