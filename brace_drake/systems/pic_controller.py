"""Position-based impedance control of one ring, the whole tick in one event."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import Context, LeafSystem

from brace_drake.errors import BraceError
from brace_drake.laws import kernels
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.hosting import EffectHost
from brace_drake.systems.ticks import DeclareTick

_NO_NOISE = np.empty(0)


def pack_tick_law(numbers: BenchNumbers) -> np.ndarray:
    """The law of a tick, see `kernels.NUM_TICK_LAW`."""
    return np.concatenate(
        [numbers.resolution, numbers.noise_sigma, numbers.controller_law]
    )


class PicController(LeafSystem):
    """PIC: equations (4), (5) outside, inverse dynamics (6) inside.

    BenchInstruments, then PoseEstimator, ImpedanceFilter, BraceInverseDynamics
    and TickHold of `controller_blocks` run as one event, with the same laws
    and to the same result, at a fraction of their cost.

    Input ports:
        measured: True leg lengths (6), m, force of the ring on the torso (3),
            N, displacement of the torso (3), m: (12,).
        desired: y_d, y_d', y_d'' (3,).
        noise: Standard normal draws of the tick (12,); left unconnected the
            readings are exact and not rounded.
        law: See `kernels.NUM_TICK_LAW` (70,).

    Output ports:
        tick: Of the last tick, held until the next: leg command (6), N;
            readings (12), as `measured`; filtered force, y_v, y_v', y_v'' (4);
            memory of the pose estimator, that is p_WR (3), q_WR (4), X (6),
            X' (6), 1: (42,).

    Parameters and states of the effects at `sensing` are this system's; the
    states advance once in each tick.
    """

    def __init__(self, numbers: BenchNumbers, plug_ins: Mapping[str, PlugIn]):
        super().__init__()
        self._period = numbers.estimator[3]
        declare = self.DeclareVectorInputPort
        self._measured_port = declare("measured", 12)
        self._desired_port = declare("desired", 3)
        self._noise_port = declare("noise", 12)
        self._law_port = declare("law", kernels.NUM_TICK_LAW)
        initial = np.zeros(kernels.NUM_TICK)
        initial[22:25], initial[25] = numbers.rest, 1.0
        held = self.DeclareDiscreteState(initial)
        self.DeclareStateOutputPort("tick", held)
        self._held = int(held)
        self._host = EffectHost(
            self, plug_ins.get("sensing") or idle("sensing")
        )
        DeclareTick(self, self._period, self._Tick)

    def _Tick(self, context: Context, discrete) -> None:
        # Discrete values start as those of the context: the last tick's.
        tick = discrete.get_mutable_value(self._held)
        measured = self._measured_port.Eval(context)
        if not self._host.is_idle:
            self._ApplyEffects(context, discrete, tick[0:6], measured)
        noise = _NO_NOISE
        if self._noise_port.HasValue(context):
            noise = self._noise_port.Eval(context)
        good = kernels.advance_tick(
            measured,
            self._desired_port.Eval(context),
            noise,
            self._law_port.Eval(context),
            tick,
        )
        if not good:
            raise BraceError(
                "PicController: no ring pose fits the measured leg lengths"
                f" at {context.get_time():.3f} s"
            )

    def _ApplyEffects(self, context: Context, discrete, u, measured) -> None:
        memory = self._host.memory(context)
        now = (context.get_time(), self._period)
        self._host.apply(context, memory, *now, u, measured[0:6], measured[6:9])
        self._host.store(memory, discrete)
