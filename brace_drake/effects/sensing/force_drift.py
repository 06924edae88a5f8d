"""A force sensor whose zero wanders."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("sensing", lanes=True)
def _law(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    F[1] += p[0] * t


CARD = Effect(
    name="force_drift",
    block="sensing",
    title="zero of the force reading that drifts",
    equation="F_y,read = F_y + r t, t from the start of a run",
    source="Fraden, Handbook of Modern Sensors, section 3.12",
    parameters=(
        EffectParameter("force_drift_N_s", "N/s", -5.0, 5.0, (0.01,), "rate r"),
    ),
    laws={"sensing": _law},
    needs=("force reading",),
    signature="a free force reading that grows with time",
    impostors={
        "force_bias": "there from the start",
        "posture_drift": "moves the torso as well",
    },
    remedy="let the force sensor warm up, and zero it before each run",
    experiment="quiet hold without contact, long",
)
