"""A machine that does not answer to small commands."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import delivered, plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    for k in range(f.shape[0]):
        # What is asked for, after the feedback of a position.
        asked = delivered(f, law, l_dot, k)
        zone = p[0] * law[k]
        left = math.copysign(max(0.0, abs(asked) - zone), asked)
        f[k] += left - asked


CARD = Effect(
    name="command_deadzone",
    block="actuation",
    title="a dead zone of the command",
    equation="r = 0 where |r| < z, else r - z sign(r); of a position, its error"
    " in the speed that it asks for",
    source="Tao and Kokotovic, Adaptive Control of Systems with Actuator and"
    " Sensor Nonlinearities, 1996, chapter 2",
    parameters=(
        EffectParameter(
            "deadzone_m_s",
            "m/s",
            0.0,
            1.0,
            (0.001, 0.005),
            "speed z up to which nothing moves",
        ),
    ),
    laws={"drive": _law},
    needs=("commanded motion",),
    signature="it stands at small commands, and is slow by as much at others",
    impostors={"force_gain": "slow in proportion"},
    remedy="look up the dead band of the servo drive; make it smaller",
    experiment="slow and fast strokes",
)
