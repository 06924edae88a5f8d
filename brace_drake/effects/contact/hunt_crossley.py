"""Damping of the tissue that grows with depth."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.elementary import power
from brace_drake.laws.lanes.functions import where

# Depth at which the stiffness is that of the linear law, whatever n is.
_DEPTH = 0.003


@plug("contact", lanes=True)
def _law(t, dt, pad, d, law, N, p, x):
    touches = d[0] > 0.0
    depth = where(touches, d[0], _DEPTH)
    shape = law[0] * depth * power(depth / _DEPTH, p[1] - 1.0)
    force = shape * (1.0 + p[0] * d[1]) + p[2] * law[1] * d[1]
    N[0] = where(touches, force, N[0])


CARD = Effect(
    name="hunt_crossley",
    block="contact",
    title="damping in proportion to the elastic force",
    equation="N = k d (d / 3 mm)^(n-1) (1 + a d') + e c d', e = 0 where it"
    " stands in place of linear damping",
    source="Hunt and Crossley, Coefficient of restitution interpreted as"
    " damping in vibroimpact, J. Appl. Mech. 42, 1975",
    parameters=(
        EffectParameter(
            "dissipation_s_m",
            "s/m",
            0.0,
            500.0,
            (8.0, 40.0, 160.0),
            "dissipation a",
        ),
        EffectParameter(
            "exponent",
            "1",
            1.0,
            2.0,
            (1.0,),
            "exponent n of the elastic force",
            off=1.0,
            choices=(1.0, 1.5),
        ),
        EffectParameter(
            "linear_share",
            "1",
            0.0,
            1.0,
            (0.0,),
            "share e of linear damping that remains",
            off=1.0,
            choices=(0.0, 1.0),
        ),
    ),
    laws={"contact": _law},
    signature="damping weak at first touch, strong at depth",
    impostors={
        "hardening": "the same at every speed",
        "relaxation": "force creeps in holds",
    },
    remedy="nothing is wrong with the machine: pads damp more the deeper they"
    " are pressed; keep the law in the twin",
    experiment="multisine at two depths",
)
