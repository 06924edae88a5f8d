"""What no motion on the bench may pass, as its twin foresees it."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import LimitsError
from brace_drake.devices.bench.rollout import CHANNELS, COMMANDS
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import SafeMotion
from brace_drake.devices.motions.reference import COLUMNS
from brace_drake.devices.subject import with_subject

EXCURSION = 0.012  # m, of the reference
_ROUNDING = 1e-9
PAD_FORCE = 50.0  # N, of one pad

_FORCE_Y = CHANNELS.index("ring2_force_y_N")


def check_reach(name: str, y: np.ndarray) -> None:
    """Refuses a reference that no device may follow.

    Args:
        name: Of the motion.
        y: Displacements of the ring along y (N,), m.

    Raises:
        LimitsError: It reaches beyond `EXCURSION`, or is no number somewhere.
    """
    reach = float(np.abs(y).max(initial=0.0))
    # Written so that what is no number is refused.
    if not reach <= EXCURSION + _ROUNDING:
        raise LimitsError(
            f"motion {name} reaches {1e3 * reach:.1f} mm, allowed"
            f" {1e3 * EXCURSION:.0f} mm"
        )


def exceeded_limit(
    twin: BenchTwin, motion: SafeMotion, subject: np.ndarray, log: np.ndarray
) -> str | None:
    """Which limit a motion passes, in words; None where it keeps them all.

    Args:
        twin: Whose legs have the limit.
        motion: The reference.
        subject: Values of the subject's parameters.
        log: The twin's recording of it (N, C).
    """
    excursion = float(np.abs(motion.run.channels[COLUMNS[0]]).max())
    if excursion > EXCURSION:
        return f"{1e3 * excursion:.1f} mm, allowed {1e3 * EXCURSION:.0f} mm"
    pad = float(largest_pad_force(twin, subject, log[:, _FORCE_Y]).max())
    if motion.contact and pad >= PAD_FORCE:
        return f"a pad force of {pad:.0f} N, allowed {PAD_FORCE:.0f} N"
    command = float(np.abs(log[:, COMMANDS]).max())
    limit = twin.scenario.leg.force_limit
    if command >= limit:
        return f"a leg force of {command:.0f} N, allowed {limit:.0f} N"
    return None


def largest_pad_force(
    twin: BenchTwin, subject: np.ndarray, force_y: np.ndarray
) -> np.ndarray:
    """Force of the pad that presses harder (N,), N.

    The reading is the difference of both. While both touch, slowly, their sum
    is 2 k p, so that the larger is |F| / 2 + k p; else it is |F|.

    Args:
        twin: Of the bench.
        subject: Values of the subject's parameters.
        force_y: Force on the torso along y (N,), N.
    """
    contact = with_subject(twin.numbers, subject).contact
    shared = contact[0] * contact[5]
    return np.maximum(np.abs(force_y), 0.5 * np.abs(force_y) + shared)
