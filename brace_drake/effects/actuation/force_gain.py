"""Drives that give more or less than they are asked for."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import delivered, plug


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    for k in range(f.shape[0]):
        f[k] += p[0] * delivered(f, law, l_dot, k)


CARD = Effect(
    name="force_gain",
    block="actuation",
    title="gain error of all drives",
    equation="f = (1 + s) u - b l'",
    source="Blanke, Kinnaert, Lunze, Staroswiecki, Diagnosis and"
    " Fault-Tolerant Control, section 4",
    parameters=(
        EffectParameter("force_gain", "1", -0.8, 2.0, (0.05,), "gain error s"),
    ),
    laws={"drive": _law},
    on_command=True,
    signature="commands off in proportion, in free runs and under load",
    impostors={
        "ring_mass": "weight alone, nothing in proportion to the push",
        "force_scale": "a reading, not a force: free runs stay as they are",
    },
    remedy="hold a known weight with each drive; correct the force constants"
    " of the drives",
    experiment="stairs: the load on the legs changes, the weight does not",
)
