"""One leg that gives less than it is asked for."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.one_leg import ONE_LEG
from brace_drake.laws.hooks import delivered, plug
from brace_drake.laws.lanes.functions import where


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    for k in range(f.shape[0]):
        lost = p[1] * delivered(f, law, l_dot, k)
        f[k] = where(p[0] == k + 1.0, f[k] - lost, f[k])


CARD = Effect(
    name="weak_leg",
    block="actuation",
    title="one drive with less force than commanded",
    equation="f_k = (1 - s) u_k - b l_k' for one leg k",
    source="Blanke, Kinnaert, Lunze, Staroswiecki, Diagnosis and"
    " Fault-Tolerant Control, section 4 (loss of effectiveness)",
    parameters=(
        ONE_LEG,
        EffectParameter(
            "force_loss", "1", -0.5, 0.95, (0.1,), "share s that is missing"
        ),
    ),
    laws={"drive": _law},
    needs=("brace",),
    on_command=True,
    signature="one leg commanded more than symmetry allows, a tilt of the ring",
    impostors={
        "force_gain": "all legs alike: no tilt",
        "anchor_error": "leg lengths off at rest as well",
    },
    remedy="exchange this drive with another: if the weakness goes along"
    " replace the drive, else look at amplifier and cable",
    experiment="stairs in both directions",
)
