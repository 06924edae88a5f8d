"""A force sensor that answers late."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.elementary import exp
from brace_drake.laws.lanes.functions import where


@plug("sensing", lanes=True)
def _law(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    # x: filtered force (3), then whether it has been started.
    slow = p[0] > 1e-6
    gain = where(slow, 1.0 - exp(-h / where(slow, p[0], 1.0)), 1.0)
    gain = where(x[3] == 0.0, 1.0, gain)
    x[3] = 1.0
    for i in range(3):
        x[i] += gain * (F[i] - x[i])
        F[i] = x[i]


CARD = Effect(
    name="force_lag",
    block="sensing",
    title="first-order lag of the force sensor",
    equation="T F_read' = F - F_read",
    source="Fraden, Handbook of Modern Sensors, section 3.16",
    parameters=(
        EffectParameter(
            "lag_s", "s", 0.0, 1.0, (0.01, 0.05), "time constant T"
        ),
    ),
    laws={"sensing": _law},
    needs=("force reading",),
    num_states={"sensing": 4},
    signature="the force trails the motion in fast contact runs",
    impostors={
        "command_delay": "free runs show it as well",
        "hunt_crossley": "depends on depth",
    },
    remedy="look for a low-pass filter of the force sensor; raise its"
    " cut-off frequency, or keep the effect in the twin",
    experiment="multisine in contact",
)
