"""Parameters that more than one effect has."""

from brace_drake.effects.card import EffectParameter

DRIVE_VISCOUS = EffectParameter(
    "drive_viscous_N_s_m",
    "N s/m",
    1.0,
    1000.0,
    (40.0,),
    "viscous friction b of the drive, as on the data sheet",
    off=None,
    choices=(40.0,),
)
