"""The parameter that says which leg an effect of one leg is on."""

from brace_drake.effects.card import EffectParameter

ONE_LEG = EffectParameter(
    "leg",
    "1",
    1.0,
    6.0,
    (1.0,),
    "number of the leg",
    off=None,
    choices=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
)
