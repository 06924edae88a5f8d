"""More, or less, viscous friction of a joint."""

from dataclasses import replace

from brace_drake.effects.actuation import viscous_leg
from brace_drake.effects.card import EffectParameter

CARD = replace(
    viscous_leg.ALONE,
    name="viscous_friction",
    form="",
    title="viscous friction off its nominal value",
    equation="F = (d_nominal + d) y'",
    parameters=(
        EffectParameter(
            "extra_viscous_N_s_m",
            "N s/m",
            -1000.0,
            1000.0,
            (20.0,),
            "coefficient d more than nominal",
        ),
    ),
    needs=("joint of a plant",),
    signature="a force in proportion to the speed",
    impostors={"coulomb_friction": "the same at all speeds"},
    remedy="move at constant speeds and read the force; check grease, seals"
    " and temperature",
    experiment="the same motion at two speeds",
)
