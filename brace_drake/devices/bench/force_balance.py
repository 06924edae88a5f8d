"""The inverse-dynamics residual of the leg forces along the recorded way.

Commands, motion and force are recorded, so that every drive can be asked
whether it gave what the ring needed: no model of contact, torso or loop enters,
and nothing is linearised.
"""

from __future__ import annotations

import numpy as np

from brace_drake.devices.bench.ring_way import RingWay
from brace_drake.laws.control.brace_control import MASS
from brace_drake.laws.numbers import BraceNumbers

# Of the low pass, and what of either end of a run it folds.
CUTOFF_HZ, MARGIN_S = 5.0, 0.5


def calc_imbalance(
    numbers: BraceNumbers, way: RingWay, touches: bool
) -> np.ndarray:
    """Commands minus what the way of the ring asks of the drives (N, 6), N.

        u - J^-T (m a - m g + F) - b l'

    Of the torso's pull on the ring the force alone is measured: where it is
    there, what a moment on the ring could make is taken off.

    Args:
        numbers: Nominal mass, weight and viscous friction.
        way: From `follow_ring`.
        touches: Whether the torso is there, so that F counts.
    """
    wrench = way.accelerations * numbers.control[MASS]
    wrench[:, 2::6] += numbers.ring[:, 4]
    if touches:
        wrench[:, 0:3] += way.force
    asked = way.leg_forces(wrench) + numbers.viscous * way.leg_rates
    lack = way.commands - asked
    return way.beyond_moments(lack) if touches else lack
