"""Soft tissue that relaxes under a pad."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.elementary import exp


@plug("contact", lanes=True)
def _law(t, dt, pad, d, law, N, p, x):
    # x[pad]: creep of the tissue, 0 where the run starts: the brace has just
    # been put on, and the arm carries its part of the preload.
    depth = max(d[0], 0.0)
    N[0] += p[0] * (depth - x[pad])
    x[pad] += (1.0 - exp(-dt / p[1])) * (depth - x[pad])


CARD = Effect(
    name="relaxation",
    block="contact",
    title="viscoelastic relaxation of the tissue under the pads",
    equation="N = k d + c d' + k_v (d - z), z' = (d - z) / tau, z = 0 at the"
    " start (standard linear solid, one Maxwell arm)",
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
    remedy="nothing is wrong with the machine: tissue gives way under load;"
    " hold a push until its force stands, and keep the law in the twin",
    experiment="stairs with long holds",
)
