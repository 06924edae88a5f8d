"""A force sensor that does not read zero at zero force."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("sensing", lanes=True)
def _law(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    F[1] += p[0]


CARD = Effect(
    name="force_bias",
    block="sensing",
    title="constant offset of the force reading along y",
    equation="F_y,read = F_y + F_0",
    source="Fraden, Handbook of Modern Sensors, section 3.4",
    parameters=(
        EffectParameter("force_bias_N", "N", -20.0, 20.0, (0.1,), "offset F_0"),
    ),
    laws={"sensing": _law},
    needs=("force reading",),
    signature="a force reading without contact; the ring gives way to a force"
    " that is not there",
    impostors={
        "anchor_error": "shows in the leg lengths, not in a free force reading"
    },
    remedy="zero the force sensor without contact before the runs",
    experiment="quiet hold without contact",
)
