"""Scales of what a playback shows: arrows of forces, colours of pressures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from brace_drake.playback.look import Look
from brace_drake.playback.states import PlaybackStates
from brace_drake.scenario.brace import Contact

_LONGEST_ARROW = 0.12  # m, the largest force's
# sRGB of a pad that does not press, and of one with the scale's last pressure.
NO_PRESSURE, TOP_PRESSURE = (
    np.array([0.98, 0.86, 0.55]),
    np.array([0.60, 0.02, 0.16]),
)


@dataclass(frozen=True)
class Scales:
    """Of one playback.

    Attributes:
        newtons_per_metre: Of the arrows.
        pressures: Of each pad's face (N, S, 2), Pa.
        top: The pressure that has the last colour, Pa.
    """

    newtons_per_metre: float
    pressures: np.ndarray
    top: float


def make_scales(look: Look, states: PlaybackStates) -> Scales:
    """Scales that keep the largest force and pressure in view."""
    pressures = calc_pressures(states.rings, states.pad_force, look.contacts)
    return Scales(
        newtons_per_metre(states.pad_force),
        pressures,
        _round_up(max(float(pressures.max(initial=0.0)), 1.0)),
    )


def newtons_per_metre(pad_force: np.ndarray) -> float:
    """Scale of the arrows: a round number that keeps the largest in view."""
    largest = np.linalg.norm(pad_force, axis=-1).max(initial=0.0)
    return _round_up(max(largest, 1e-3) / _LONGEST_ARROW)


def calc_pressures(
    rings: np.ndarray,
    pad_force: np.ndarray,
    contacts: Sequence[Contact | None],
) -> np.ndarray:
    """Mean pressure of each pad's face: force along its normal over its area.

    Args:
        rings: q_WR, p_WR of each ring (N, S, 7).
        pad_force: On the torso in W (N, S, 2, 3), N, left pad, at +y, first.
        contacts: Of each ring; None: it has no pads.

    Returns:
        (N, S, 2), Pa, 0 where a pad does not press.
    """
    pressures = np.zeros(pad_force.shape[:3])
    for i, contact in enumerate(contacts):
        if contact is None:
            continue
        turned = Rotation.from_quat(rings[:, i, 0:4], scalar_first=True)
        to_left = turned.apply([0.0, 1.0, 0.0])[:, None]
        # The left pad presses along -y of its ring.
        inwards = (pad_force[:, i] * to_left).sum(axis=-1) * [-1.0, 1.0]
        area = float(contact.pad_size[0] * contact.pad_size[2])
        pressures[:, i] = np.maximum(inwards, 0.0) / area
    return pressures


def colour_of(share: float) -> list[float]:
    """Of a pressure, as a share of the top one: linear RGB, as 3D has it."""
    colour = NO_PRESSURE + min(share, 1.0) * (TOP_PRESSURE - NO_PRESSURE)
    return (colour**2.2).tolist()


def _round_up(least: float) -> float:
    """The next of 1, 2, 5, 10, 20 and so on."""
    power = 10.0 ** np.floor(np.log10(least))
    return float(power * next(n for n in (1, 2, 5, 10) if n * power >= least))
