"""The inverse-dynamics residual of the leg forces along the recorded way.

Commands, motion and force are recorded, so that every drive can be asked
whether it gave what the ring needed: no model of contact, torso or loop enters,
and nothing is linearised.
"""

from __future__ import annotations

import numpy as np

from brace_drake.devices.bench.force_balance_terms import (
    drive_terms,
    reading_terms,
    ring_terms,
)
from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.bench.ring_way import RingWay, follow_ring
from brace_drake.devices.bench.rollout import COMMANDS
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.declaration import Term
from brace_drake.laws.control.brace_control import MASS
from brace_drake.laws.numbers import BraceNumbers

# Of the low pass, and what of either end of a run it folds.
CUTOFF_HZ, MARGIN_S = 5.0, 0.5
# Of the signals that errors are made of.
_SIGNAL_HZ = 15.0
# Samples that are compared, a bit more than the low pass leaves of them.
_COMPARED_HZ = 20.0
# Relative length of a shape that a moment of the torso's could have.
_MOMENT = 1e-2


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


def balance_of_run(
    twin: BenchTwin, prepared, rate: float
) -> tuple[np.ndarray, dict[str, list[Term]]] | None:
    """What the balance of a run lacks (M,), and errors of each block, in terms
    of the root of their number: each run counts as it does in a block test.

    None of a run without commands or of less than a second.
    """
    numbers, x = twin.numbers, prepared.measured
    touches = prepared.run.contact
    edge, every = int(MARGIN_S * rate), max(1, int(rate / _COMPARED_HZ))
    has_commands = prepared.run.has(twin.channels[COMMANDS]).all()
    if len(x) <= 2 * edge or not has_commands:
        return None
    gravity = numbers.ring[0, 4] / numbers.ring[0, 0]
    way = follow_ring(numbers, x, rate, CUTOFF_HZ)
    lack = calc_imbalance(numbers, way, touches)
    # The errors' own corners lie above the low pass, which comes last.
    signals = follow_ring(numbers, x, rate, _SIGNAL_HZ)

    def cut(values):
        inner = values[edge : len(values) - edge : every].ravel()
        return inner / np.sqrt(len(inner))

    def see(shape):
        """An error as it shows in what the balance lacks."""
        slow = low_pass(shape, CUTOFF_HZ, rate)
        if not touches:
            return cut(slow)
        seen = way.beyond_moments(slow)
        is_moment = np.linalg.norm(seen) < _MOMENT * np.linalg.norm(slow)
        return cut(np.zeros_like(seen) if is_moment else seen)

    terms = {
        "actuation": drive_terms(signals),
        "mechanism": ring_terms(signals, gravity),
        "sensing": reading_terms(signals, touches),
    }
    return cut(lack), {
        block: [Term(t.title, t.unit, see(t.shape)) for t in found]
        for block, found in terms.items()
    }
