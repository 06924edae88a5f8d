"""Pads that do not touch where they should."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.functions import where


@plug("compression", lanes=True)
def _law(t, dt, pad, d, p, x):
    own = where(p[0] == 0.0, pad + 1.0, p[0])
    d[0] -= where(own == pad + 1.0, p[1], 0.0)


CARD = Effect(
    name="clearance",
    block="contact",
    title="clearance between pad and torso",
    equation="N = k (d - s) + c d' where d > s, else 0; at both pads or one",
    source="Johnson, Contact Mechanics, section 11; a brace that sits loose",
    parameters=(
        EffectParameter(
            "pad",
            "1",
            0.0,
            2.0,
            (0.0,),
            "which pad: 0 both, 1 at +y, 2 at -y",
            off=None,
            choices=(0.0, 1.0, 2.0),
            words=("both pads", "pad at +y", "pad at -y"),
        ),
        EffectParameter(
            "clearance_m",
            "m",
            0.0,
            0.02,
            (5e-4, 2e-3),
            "width s of the clearance",
        ),
    ),
    laws={"compression": _law},
    signature="no force over the first part of a push, then the usual one",
    impostors={
        "hardening": "grows with depth, no threshold",
        "backlash": "in the legs: shows in free runs as well",
    },
    remedy="fit the pad anew, or begin the push nearer to the torso",
    experiment="slow reversals through the rest position",
)
