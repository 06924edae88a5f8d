"""A machine that does not answer to small commands."""

import math
from dataclasses import replace

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


@plug("drive")
def _law_of_band(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    for k in range(f.shape[0]):
        asked = delivered(f, law, l_dot, k)
        if abs(asked) < p[0] * law[k]:
            f[k] -= asked


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

# Of hobby servos: within the band the motor is off, beyond it all of the error
# counts.
BAND = replace(
    CARD,
    form="band",
    title="a dead band: nothing within it, all beyond",
    equation="r = 0 where |r| < z, else r; of a position, its error in the"
    " speed that it asks for",
    laws={"drive": _law_of_band},
    signature="it stops short of where it was sent, by no more than the band",
)

CARDS = (CARD, BAND)
