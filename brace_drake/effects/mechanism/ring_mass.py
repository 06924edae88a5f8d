"""A ring that is heavier than drawn."""

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter


def _modify(numbers, values: np.ndarray):
    ring = numbers.ring.copy()
    ring[:, 0] += values[0]
    ring[:, 4] *= ring[:, 0] / numbers.ring[:, 0]
    return numbers.with_changes(ring=ring)


CARD = Effect(
    name="ring_mass",
    block="mechanism",
    title="mass of the ring off its data sheet value",
    equation="(m + dm) v' = sum of forces - (m + dm) g z; the controller"
    " counts with m",
    source="Khalil and Dombre, Modeling, Identification and Control of Robots,"
    " chapter 12",
    parameters=(
        EffectParameter(
            "added_mass_kg", "kg", -0.6, 5.0, (0.1,), "added mass dm"
        ),
    ),
    modify=_modify,
    signature="the ring sags by a constant; inertial forces off in proportion",
    impostors={
        "force_gain": "acts on the pushing force as well as on the weight"
    },
    remedy="weigh the ring with all that is on it; write its mass into the"
    " scenario",
    experiment="quiet hold without contact, then fast free motion",
)
