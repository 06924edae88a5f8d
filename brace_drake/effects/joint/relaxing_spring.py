"""A spring that gives way with time."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    # x: end of the damper (n), and whether it is known: a run begins at ease.
    n = f.shape[0]
    for k in range(n):
        if x[n] == 0.0:
            x[k] = l[k]
        f[k] -= p[0] * (l[k] - x[k])
        x[k] += (1.0 - math.exp(-dt / p[1])) * (l[k] - x[k])
    x[n] = 1.0


CARD = Effect(
    name="relaxing_spring",
    block="mechanism",
    title="a spring that relaxes",
    equation="F = k_v (y - z), z' = (y - z) / tau, z = y at the start (one"
    " Maxwell arm)",
    source="Lakes, Viscoelastic Materials, 2009, section 2.6",
    parameters=(
        EffectParameter(
            "arm_stiffness_N_m",
            "N/m",
            0.0,
            1e5,
            (300.0,),
            "stiffness k_v of the relaxing arm",
        ),
        EffectParameter(
            "relaxation_time_s",
            "s",
            0.02,
            200.0,
            (0.1, 1.0, 10.0),
            "time constant tau",
            off=None,
        ),
    ),
    laws={"drive": _law},
    num_states={"drive": 7},
    needs=("one joint", "joint position"),
    signature="force falls in a hold, and fast strokes are stiffer than slow",
    impostors={
        "stiffening": "the same force at the same place, however fast",
        "joint_spring": "the same, in proportion to the place",
    },
    remedy="wait after each step until the force stands; look at belts, hoses"
    " and soft parts",
    experiment="steps with long holds",
)
