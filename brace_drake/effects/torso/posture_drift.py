"""A patient who gives way slowly."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.elementary import exp


@plug("torso", lanes=True)
def _law(t, dt, p_T, r_T, V, law, F, p, x):
    # The posture pulls to y_0 in place of 0.
    F[4] += law[1] * p[0] * p[1] * (1.0 - exp(-t / p[1]))


CARD = Effect(
    name="posture_drift",
    block="torso",
    title="rest pose that drifts during a run",
    equation="f = -K (y - y_0(t)) - D y', y_0 = v T (1 - exp(-t / T))",
    source="Duarte and Zatsiorsky, Patterns of center of pressure migration"
    " during prolonged unconstrained standing, Motor Control 3, 1999",
    parameters=(
        EffectParameter(
            "drift_m_s", "m/s", -0.01, 0.01, (5e-5,), "speed v at the start"
        ),
        EffectParameter(
            "drift_time_s",
            "s",
            0.5,
            1000.0,
            (5.0, 60.0),
            "time T over which it dies out",
            off=None,
        ),
    ),
    laws={"torso": _law},
    signature="torso and force creep from the start of a run on, push or none",
    impostors={
        "relaxation": "starts anew with every change of depth",
        "force_drift": "the reading alone, the torso stays",
    },
    remedy="support the pelvis, make runs shorter, and let the subject rest"
    " between them",
    experiment="quiet hold in contact, long",
)
