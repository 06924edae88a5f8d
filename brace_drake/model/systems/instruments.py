"""A brace's instruments: leg encoders, force sensors, torso marker."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws.loop.ticks import round_readings
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.model.systems.hosting import EffectHost
from brace_drake.model.systems.ticks import DeclareTick


class BraceInstruments(LeafSystem):
    """Readings at a tick: ideal value, effects, noise, rounding.

    Input ports:
        measured: True leg lengths (6 S), m, force of each ring on the torso
            (3 S), N, displacement of the torso (3), m.
        held_command: Commands of the last tick (6 S,), N; only effects look
            at them.
        noise: Standard normal draws of the tick (9 S + 3,); left unconnected
            the readings are exact and not rounded.

    Output ports:
        readings: As `measured`.
        held_readings: Those of the last tick; only where effects have changed
            their states since, see `logged_port`.

    Attributes:
        logged_port: What a log right behind a tick takes: readings of it.

    Numeric parameters: resolution (2,), of lengths, m, and forces, N, and
    noise_sigma (9 S + 3,); those of effects at `sensing`, whose states advance
    once in each tick.
    """

    def __init__(
        self,
        resolution: np.ndarray,
        noise_sigma: np.ndarray,
        period: float,
        plug_ins: Mapping[str, PlugIn] | None = None,
    ):
        super().__init__()
        self._period, size = period, len(noise_sigma)
        self._num_lengths = 2 * (size - 3) // 3
        self._measured_port, self._held_port, self._noise_port = (
            self.DeclareVectorInputPort(name, width)
            for name, width in (
                ("measured", size),
                ("held_command", self._num_lengths),
                ("noise", size),
            )
        )
        self._resolution, self._sigma = (
            int(self.DeclareNumericParameter(BasicVector(a)))
            for a in (resolution, noise_sigma)
        )
        self._host = EffectHost(
            self,
            (plug_ins or {}).get("sensing") or idle("sensing"),
            self._num_lengths // 6,
        )
        self._output = self.DeclareVectorOutputPort(
            "readings", size, self._CalcReadings
        )
        self._readings = np.empty(size)
        self.logged_port = self._output
        if not self._host.is_idle:
            held = self.DeclareDiscreteState(size)
            self._held = int(held)
            self.logged_port = self.DeclareStateOutputPort(
                "held_readings", held
            )
            DeclareTick(self, self._period, self._Advance)

    def _Eval(self, context: Context):
        readings = self._readings
        readings[:] = self._measured_port.Eval(context)
        memory = self._host.memory(context)
        if not self._host.is_idle:
            times = context.get_time(), self._period
            held = self._held_port.Eval(context)
            self._host.read(context, memory, times, held, readings)
        if self._noise_port.HasValue(context):
            resolution = context.get_numeric_parameter(self._resolution)
            sigma = context.get_numeric_parameter(self._sigma)
            noise = self._noise_port.Eval(context) * sigma.value()
            round_readings(resolution.value(), noise, readings)
        return memory

    def _CalcReadings(self, context: Context, output: BasicVector) -> None:
        self._Eval(context)
        output.SetFromVector(self._readings)

    def _Advance(self, context: Context, discrete) -> None:
        memory = self._Eval(context)
        discrete.get_mutable_vector(self._held).SetFromVector(self._readings)
        self._host.store(memory, discrete)
