"""All that may be off on a bench within tolerances, at once, as one effect.

It takes one place of a twin: another effect has room beside it.
"""

import numpy as np

from brace_drake.effects.actuation import (
    command_delay,
    coulomb_friction,
    viscous_leg,
)
from brace_drake.effects.card import Effect
from brace_drake.effects.mechanism import anchor_error, ring_mass
from brace_drake.effects.sensing import force_bias, force_scale
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.functions import some

# Numbers in the order of p, with the card that puts each off; then anchors.
NUMBERS = {
    "ring_mass_kg": ring_mass.CARD,
    "leg_viscous_N_s_m": viscous_leg.CARD,
    "leg_dry_friction_N": coulomb_friction.CARD,
    "force_scale": force_scale.CARD,
    "force_bias_N": force_bias.CARD,
    "command_delay_s": command_delay.CARD,
}
ANCHORS = anchor_error.CARD
_DELAY, _DRY = command_delay.CARD, coulomb_friction.CARD
_delay, _dry = _DELAY.laws["drive"], _DRY.laws["drive"]
_scale, _bias = (c.CARD.laws["sensing"] for c in (force_scale, force_bias))
_LATE = _DELAY.num_states["drive"]


@plug("drive", lanes=True)
def _drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    # Commands first; x: those kept of the past, then deflections of bristles.
    if some(p[5] > 0.0):
        _delay(t, dt, u, l, l_dot, law, f, p[5:6], x[:_LATE])
    _dry(t, dt, u, l, l_dot, law, f, p[2:3], x[_LATE:])


@plug("sensing", lanes=True)
def _sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    _scale(t, h, u, l, F, p[3:4], x)
    _bias(t, h, u, l, F, p[4:5], x)


def _modify(numbers, values: np.ndarray):
    heavier = ring_mass.CARD.modify(numbers, values[0:1])
    slower = viscous_leg.CARD.modify(heavier, values[1:2])
    return ANCHORS.modify(slower, values[len(NUMBERS) :])


WITHIN_TOLERANCES = Effect(
    name="within_tolerances",
    block="mechanism",
    title="all numbers off within their tolerances",
    equation="those of its parts",
    source="those of its parts",
    parameters=(
        *(card.parameters[0] for card in NUMBERS.values()),
        *ANCHORS.parameters,
    ),
    modify=_modify,
    laws={"drive": _drive, "sensing": _sensing},
    num_states={"drive": _LATE + _DRY.num_states["drive"]},
    dithered=True,
    on_command=True,
    signature="none: it is no finding",
    impostors={},
    experiment="none",
)
