"""Position-based impedance control with its instruments, in one event."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import Context, LeafSystem

from brace_drake.core.errors import BraceError
from brace_drake.laws.control import brace_control
from brace_drake.laws.loop import kernels
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.model.systems.brace_controller import PROBLEMS
from brace_drake.model.systems.hosting import EffectHost
from brace_drake.model.systems.ticks import DeclareTick
from brace_drake.scenario.brace_numbers import BraceNumbers
from brace_drake.scenario.control_numbers import ControlNumbers

_NO_NOISE = np.empty(0)


def pack_tick_law(numbers: BraceNumbers, control: ControlNumbers) -> np.ndarray:
    """The law of a tick, see `kernels.num_tick_law`."""
    arrays = numbers.resolution, numbers.noise_sigma, control.law
    return np.concatenate([np.ravel(a) for a in arrays])


class PicController(LeafSystem):
    """PIC: equations (4), (5) outside, inverse dynamics (6) inside.

    `BraceInstruments` and `BracePic` as one system, with the same laws and to
    the same result. Nothing else is its own: it is here as an event less in
    each tick, and one vector for all that is held, make the bench's diagram
    1.2 (plant step 0.2 ms) to 1.4 times (0.5 ms) as fast.

    Input ports:
        measured: Of S stages true leg lengths (6 S), m, force of each ring on
            the torso (3 S), N, displacement of the torso (3), m.
        desired: y_d of each ring, then y_d', y_d'' (3 S,); else X_d is 0.
        noise: Standard normal draws of the tick (9 S + 3,); left unconnected
            the readings are exact and not rounded.
        law: See `kernels.num_tick_law`.

    Output ports:
        tick: Of the last tick, held until the next, see `kernels.tick_sizes`.

    Parameters and states of the effects at `sensing`, which sit on one stage,
    are this system's; the states advance once in each tick.
    """

    def __init__(self, control: ControlNumbers, plug_ins: Mapping[str, PlugIn]):
        super().__init__()
        self._period, n = control.period, len(control.pose) // 20
        self._legs, self._forces = slice(0, 6 * n), slice(6 * n, 9 * n)
        declare = self.DeclareVectorInputPort
        self._measured_port = declare("measured", 9 * n + 3)
        self._desired_port = declare("desired", 3 * n)
        self._noise_port = declare("noise", 9 * n + 3)
        self._law_port = declare("law", kernels.num_tick_law(n))
        self._X_d = np.zeros(18 * n)
        still = np.zeros(15 * n + 3), control.virtual, np.zeros(24 * n)
        held = self.DeclareDiscreteState(np.concatenate([*still, control.pose]))
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
            self._ApplyEffects(context, discrete, tick[self._legs], measured)
        noise = _NO_NOISE
        if self._noise_port.HasValue(context):
            noise = self._noise_port.Eval(context)
        self._X_d[1::6] = self._desired_port.Eval(context)
        result = kernels.advance_tick(
            measured,
            self._X_d,
            noise,
            self._law_port.Eval(context),
            tick,
        )
        if result != brace_control.GOOD:
            raise BraceError(
                f"PicController: {PROBLEMS[result]}"
                f" at {context.get_time():.3f} s"
            )

    def _ApplyEffects(self, context: Context, discrete, u, measured) -> None:
        memory = self._host.memory(context)
        now = (context.get_time(), self._period)
        lengths, force = measured[self._legs], measured[self._forces]
        self._host.apply(context, memory, *now, u, lengths, force)
        self._host.store(memory, discrete)
