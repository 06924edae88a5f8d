"""A force sensor with a wrong gain."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("sensing", lanes=True)
def _law(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    for i in range(3):
        F[i] *= 1.0 + p[0]


CARD = Effect(
    name="force_scale",
    block="sensing",
    title="gain error of the force sensor",
    equation="F_read = (1 + s) F",
    source="Fraden, Handbook of Modern Sensors, section 3.3",
    parameters=(
        EffectParameter("force_scale", "1", -0.8, 2.0, (0.05,), "gain error s"),
    ),
    laws={"sensing": _law},
    needs=("force reading",),
    signature="force reading and motion of torso and ring disagree by a"
    " constant factor",
    impostors={"force_gain": "a gain of the drives, seen in free runs as well"},
    remedy="hang a known weight on the force sensor and correct its"
    " sensitivity",
    experiment="stairs; the torso's motion carries the comparison",
)
