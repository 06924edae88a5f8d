"""Tissue that takes another way back."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.elementary import exp, power
from brace_drake.laws.lanes.functions import where

# A loop that is lost once the pad is off is lost within this time.
_FORGET = 0.05  # s


@plug("contact", lanes=True)
def _law(t, dt, pad, d, law, N, p, x):
    # x[pad]: hysteretic variable z, advanced while the pad touches.
    touches, z = d[0] > 0.0, x[pad]
    N[0] = where(touches, N[0] + p[0] * z, N[0])
    step = dt * d[1] / p[1]
    against = where(step * z > 0.0, power(abs(z), p[2]), 0.0)
    loaded = min(max(z + step * (1.0 - against), -1.0), 1.0)
    x[pad] = where(touches, loaded, z * exp(-p[3] * dt / _FORGET))


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
        "relaxation": "the loop's width depends on speed, force creeps in"
        " holds",
        "hardening": "force comes back on the way that it went",
    },
    remedy="nothing is wrong with the machine: tissue keeps a part of the"
    " force; push slowly a few times before recording, and keep the law"
    " in the twin",
    experiment="reversals at two speeds with the same depth",
)
