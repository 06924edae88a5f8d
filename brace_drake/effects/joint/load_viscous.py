"""Viscous friction that changes with a measured load or temperature."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    # law holds the viscous friction of each joint, then the extra inputs; the
    # axis puts the input's place behind the parameters.
    n = f.shape[0]
    for k in range(n):
        f[k] -= p[0] * law[n + int(p[1])] * l_dot[k]


CARD = Effect(
    name="load_viscous",
    block="actuation",
    title="viscous friction that changes with a load or a temperature",
    equation="F = b' i y', i an extra input; the nominal damper has the rest",
    source="Bittencourt and Axelsson, Modeling and experiment design for"
    " identification of wear in a robot joint under load and temperature"
    " uncertainties, IEEE/ASME Transactions on Mechatronics 19, 2014",
    parameters=(
        EffectParameter(
            "damping_N_s_m_input",
            "N s/m/input",
            -2000.0,
            2000.0,
            (50.0,),
            "damping b' that each unit of the input adds, or takes",
            off=0.0,
        ),
    ),
    laws={"drive": _law},
    needs=("one joint", "extra input"),
    signature="the loop between both directions grows with the speed, and by"
    " how much goes with the input",
    impostors={"load_friction": "the same at any speed"},
    remedy="warm the machine up before it is measured; give the twin a damping"
    " for each temperature",
    experiment="the same strokes cold and warm, at two speeds",
)
