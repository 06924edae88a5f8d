"""Tissue that takes another way back."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug

# A loop that is lost once the pad is off is lost within this time.
_FORGET = 0.05  # s


@plug("contact")
def _law(t, dt, pad, d, law, N, p, x):
    # x[pad]: hysteretic variable z, advanced while the pad touches.
    if d[0] <= 0.0:
        x[pad] *= math.exp(-p[3] * dt / _FORGET)
        return
    z = x[pad]
    N[0] += p[0] * z
    step = dt * d[1] / p[1]
    against = 1.0 if step * z > 0.0 else 0.0
    z += step * (1.0 - against * math.pow(abs(z), p[2]))
    x[pad] = min(max(z, -1.0), 1.0)


CARD = Effect(
    name="hysteresis",
    block="contact",
    title="hysteresis of the tissue, whatever the speed",
    equation="N = k d + c d' + F_h z, z' = (d' / d_h) (1 - |z|^n (1 +"
    " sign(d' z)) / 2) (Bouc-Wen)",
    source="Wen, Method for random vibration of hysteretic systems, J. Eng."
    " Mech. Div. ASCE 102, 1976",
    parameters=(
        EffectParameter(
            "hysteretic_force_N",
            "N",
            0.0,
            200.0,
            (1.0,),
            "half the width F_h of the loop",
        ),
        EffectParameter(
            "hysteretic_depth_m",
            "m",
            3e-5,
            0.02,
            (3e-4, 2e-3),
            "depth d_h over which it builds up",
            off=None,
        ),
        EffectParameter(
            "sharpness",
            "1",
            0.5,
            4.0,
            (1.0,),
            "exponent n of the turn",
            off=None,
            choices=(1.0, 2.0),
        ),
        EffectParameter(
            "forgets",
            "1",
            0.0,
            1.0,
            (1.0,),
            "whether the loop is lost once the pad is off: 1 yes, 0 no",
            off=None,
            choices=(0.0, 1.0),
            words=("kept while the pad is off", "lost once the pad is off"),
        ),
    ),
    laws={"contact": _law},
    num_states={"contact": 2},
    dithered=True,
    signature="a loop between force and depth as wide in slow as in fast runs",
    impostors={
        "relaxation": "the loop's width depends on speed, force creeps in holds"
    },
    experiment="reversals at two speeds with the same depth",
)
