"""Viscous friction that is different in each direction."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    for k in range(f.shape[0]):
        f[k] -= p[0] * abs(l_dot[k])


CARD = Effect(
    name="asymmetric_viscous",
    block="actuation",
    title="viscous friction that is different in each direction",
    equation="f = u - b l' - b_a |l'|: b + b_a forwards, b - b_a backwards",
    source="Janot, Gautier, Brunot, Data set and reference models of EMPS,"
    " Nonlinear System Identification Benchmarks, 2019",
    parameters=(
        EffectParameter(
            "asymmetry_N_s_m",
            "N s/m",
            -1000.0,
            1000.0,
            (20.0,),
            "half the difference b_a of the coefficients forwards and"
            " backwards",
        ),
    ),
    laws={"drive": _law},
    # Legs of a stage move with and against each other: only a drive alone has
    # a direction that is the machine's.
    needs=("one joint",),
    signature="a force in proportion to speed that has the same sign both ways",
    impostors={
        "coulomb_friction": "the same at all speeds, and turns with direction"
    },
    remedy="compare bearings, seals or valves for both directions; give the"
    " twin a damping for each",
    experiment="strokes at two speeds, both ways",
)
