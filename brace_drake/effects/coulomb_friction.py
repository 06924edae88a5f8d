"""Dry friction in the drives of the legs."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, f, p, x):  # noqa: E741 (l: leg length)
    for k in range(f.shape[0]):
        f[k] -= p[0] * math.tanh(l_dot[k] / p[1])


CARD = Effect(
    name="coulomb_friction",
    block="actuation",
    title="dry friction in the legs",
    equation="f = u - b l' - F_c tanh(l' / v_s)",
    source="Armstrong-Helouvry, Dupont, Canudas de Wit, A survey of models,"
    " analysis tools and compensation methods for the control of machines with"
    " friction, Automatica 30, 1994",
    parameters=(
        EffectParameter(
            "coulomb_N", "N", 0.0, 60.0, (0.5,), "friction force of one leg"
        ),
        EffectParameter(
            "regularization_m_s",
            "m/s",
            2e-4,
            2e-2,
            (2e-3,),
            "speed at which friction is three quarters developed",
        ),
    ),
    laws={"drive": _law},
    signature="commands step by twice the friction at every reversal; a free"
    " run shows it as clearly as a push",
    impostors={
        "viscous_leg": "grows with speed; compare slow and fast runs",
        "command_delay": "no step at reversals; grows with acceleration",
    },
    experiment="slow reversals without contact",
    devices=("bench stage 2", "leg bench"),
)
