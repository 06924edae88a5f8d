"""Soft tissue that relaxes under a pad."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("contact")
def _law(t, dt, pad, d, law, N, p, x):
    # x[pad]: force of the Maxwell arm, zero where the run starts.
    arm = x[pad]
    N[0] += arm
    decay = math.exp(-dt / p[1])
    x[pad] = decay * arm + p[0] * p[1] * (1.0 - decay) * d[1]


CARD = Effect(
    name="relaxation",
    block="contact",
    title="viscoelastic relaxation of the tissue under the pads",
    equation="N = k d + c d' + q, q' = k_v d' - q / tau (standard linear"
    " solid, one Maxwell arm)",
    source="Fung, Biomechanics: Mechanical Properties of Living Tissues,"
    " section 2.11; times and fractions: Zheng and Mak 1999",
    parameters=(
        EffectParameter(
            "arm_stiffness_N_m",
            "N/m",
            0.0,
            30000.0,
            (1500.0,),
            "stiffness k_v of the relaxing arm",
        ),
        EffectParameter(
            "relaxation_time_s",
            "s",
            0.08,
            60.0,
            (0.5, 2.0, 8.0),
            "time constant tau",
        ),
    ),
    laws={"contact": _law},
    num_states={"contact": 2},
    signature="force creeps back in every hold after a push",
    impostors={
        "posture_drift": "grows with time of the run, not after each step",
        "hardening": "the same force at the same depth, however fast",
    },
    experiment="stairs with long holds",
)
