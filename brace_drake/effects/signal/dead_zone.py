"""Dead zone of a command."""

import math

from brace_drake.effects.card import EffectParameter
from brace_drake.effects.signal.ways import COMMAND, signal_cards
from brace_drake.laws.hooks import plug


@plug("signal")
def _law(t, dt, y, p, x):
    y[0] = math.copysign(max(0.0, abs(y[0]) - p[0]), y[0])


CARDS = signal_cards(
    "deadzone",
    "dead zone",
    _law,
    (
        EffectParameter(
            "deadzone", "signal", 0.0, 1.0, (0.05, 0.2), "half width w"
        ),
    ),
    ways=(COMMAND,),
    equation="y = 0 where |s| < w, else s - w sign(s)",
    source="Tao and Kokotovic, Adaptive Control of Systems with Actuator and"
    " Sensor Nonlinearities, 1996, chapter 2",
    signature="nothing at small commands, less by as much at large ones",
    impostors={"command_gain": "in proportion at any size"},
    remedy="read this channel over small inputs; correct it for the dead zone",
    experiment="the same motion at two amplitudes",
)
