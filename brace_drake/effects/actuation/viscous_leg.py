"""More (or less) viscous friction in the legs than the data sheet says."""

from dataclasses import replace

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


def _modify(numbers, values: np.ndarray):
    # Friction of the drive, behind its spring or gap where it has one.
    changed = np.maximum(numbers.viscous + values[0], 0.0)
    return numbers.with_changes(viscous=changed)


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    for k in range(f.shape[0]):
        f[k] -= p[0] * l_dot[k]


CARD = Effect(
    name="viscous_leg",
    block="actuation",
    title="viscous friction of the legs off its data sheet value",
    equation="f = u - (b + b_x) l'",
    source="Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30, 1994",
    parameters=(
        EffectParameter(
            "extra_viscous_N_s_m",
            "N s/m",
            -40.0,
            1000.0,
            (20.0,),
            "added to the nominal coefficient of every leg",
        ),
    ),
    modify=_modify,
    signature="a command proportional to leg speed, in free runs too",
    impostors={
        "coulomb_friction": "the same at all speeds, steps at reversals",
        "command_delay": "acts on accelerations and on contact as well",
    },
    remedy="drive a leg at constant speeds and read its force; check grease"
    " and temperature, then write the number into the scenario",
    experiment="free multisine at two amplitudes",
)
# On a machine whose numbers are not those of a brace.
ALONE = replace(
    CARD,
    form="one drive",
    modify=None,
    laws={"drive": _law},
    needs=("one drive",),
)

CARDS = (CARD, ALONE)
