"""The recorded trajectory of the ring, and its leg forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from brace_drake.devices.bench.recorded_motion import low_pass, ring_poses
from brace_drake.devices.bench.rollout import COMMANDS, FORCE, LENGTHS
from brace_drake.laws.numbers import BraceNumbers


class RingWay(NamedTuple):
    """The ring's way and what was recorded on it, through one low pass.

    Attributes:
        rate: Of the samples, Hz.
        poses, velocities, accelerations: Of the ring (N, 6), m and rad.
        lengths, leg_rates, commands: Of the legs (N, 6), m, m/s and N.
        force: Measured between ring and torso (N, 3), N.
        unit_forces: Leg forces of unit wrenches, J^-T (N, 6, 6).
    """

    rate: float
    poses: np.ndarray
    velocities: np.ndarray
    accelerations: np.ndarray
    lengths: np.ndarray
    leg_rates: np.ndarray
    commands: np.ndarray
    force: np.ndarray
    unit_forces: np.ndarray

    def leg_forces(self, wrenches: np.ndarray) -> np.ndarray:
        """Leg forces (N, 6) that give wrenches (N, 6) on the ring."""
        return np.einsum("nki,ni->nk", self.unit_forces, wrenches)

    def beyond_moments(self, forces: np.ndarray) -> np.ndarray:
        """What of leg forces (N, 6) no moment on the ring could make."""
        basis = np.linalg.qr(self.unit_forces[:, :, 3:])[0]
        along = np.einsum("nki,nk->ni", basis, forces)
        return forces - np.einsum("nki,ni->nk", basis, along)


def follow_ring(
    numbers: BraceNumbers, x: np.ndarray, rate: float, cutoff_hz: float
) -> RingWay:
    """The way of the ring in a recording.

    Args:
        numbers: Whose nominal anchors count.
        x: Channels of the bench (N, C).
        rate: Hz.
        cutoff_hz: Of the low pass.
    """
    slow = low_pass(x[:, : FORCE.stop], cutoff_hz, rate)
    poses, jacobians = ring_poses(numbers, slow[:, LENGTHS])
    velocities = slope(poses, rate)
    return RingWay(
        rate,
        poses,
        velocities,
        slope(velocities, rate),
        slow[:, LENGTHS],
        np.einsum("nij,nj->ni", jacobians, velocities),
        slow[:, COMMANDS],
        slow[:, FORCE],
        np.linalg.inv(np.transpose(jacobians, (0, 2, 1))),
    )


def slope(values: np.ndarray, rate: float) -> np.ndarray:
    """Derivative of samples (N, ...) by time, of a cubic spline through them.

    Differences of neighbours lose a third of what is at half of the highest
    frequency, a spline a twentieth.
    """
    times = np.arange(len(values)) / rate
    return CubicSpline(times, values)(times, 1)
