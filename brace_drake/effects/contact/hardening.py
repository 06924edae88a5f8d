"""Tissue that stiffens as a pad sinks in."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("contact", lanes=True)
def _law(t, dt, pad, d, law, N, p, x):
    depth = max(d[0], 0.0)
    N[0] += p[0] * depth * depth * depth


CARD = Effect(
    name="hardening",
    block="contact",
    title="contact that stiffens with depth",
    equation="N = k d + k_3 d^3 + c d'",
    source="Tsitlik et al., Elastic properties of the human chest during"
    " cardiopulmonary resuscitation, Crit. Care Med. 11, 1983 (hardening);"
    " cubic term: Nayfeh and Mook, Nonlinear Oscillations, section 4.1",
    parameters=(
        EffectParameter(
            "cubic_stiffness_N_m3",
            "N/m^3",
            0.0,
            3e10,
            (3e8,),
            "coefficient k_3",
        ),
    ),
    laws={"contact": _law},
    signature="force grows faster than depth, the same at every speed",
    impostors={
        "relaxation": "depends on how long a push lasts",
        "clearance": "a threshold, then a constant stiffness",
    },
    remedy="nothing is wrong with the machine: tissue stiffens when pressed;"
    " keep the law in the twin, and plan forces with it",
    experiment="stairs to the full depth",
)
