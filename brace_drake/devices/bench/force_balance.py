"""The balance of the leg forces along the recorded way of the ring.

Commands, motion and force are recorded, so that every drive can be asked
whether it gave what the ring needed: no model of contact, torso or loop enters,
and nothing is linearised.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from brace_drake.devices.bench.recorded_motion import low_pass, ring_poses
from brace_drake.devices.bench.rollout import COMMANDS, FORCE, LENGTHS
from brace_drake.laws.control.brace_control import MASS
from brace_drake.scenario.bench_numbers import BenchNumbers

# Of the low pass, and what of either end of a run it folds.
CUTOFF_HZ, MARGIN_S = 5.0, 0.5


@dataclass(frozen=True)
class RingWay:
    """The ring's way and what was recorded on it, through one low pass.

    Attributes:
        rate: Of the samples, Hz.
        poses, velocities, accelerations: Of the ring (N, 6), m and rad.
        jacobians: Of the legs (N, 6, 6).
        lengths, commands: Of the legs (N, 6), m and N.
        force: Measured between ring and torso (N, 3), N.
    """

    rate: float
    poses: np.ndarray
    velocities: np.ndarray
    accelerations: np.ndarray
    jacobians: np.ndarray
    lengths: np.ndarray
    commands: np.ndarray
    force: np.ndarray

    def leg_forces(self, wrenches: np.ndarray) -> np.ndarray:
        """Leg forces (N, 6) that give wrenches (N, 6) on the ring."""
        return np.einsum("nki,ni->nk", self._forces_of, wrenches)

    def beyond_moments(self, forces: np.ndarray) -> np.ndarray:
        """What of leg forces (N, 6) no moment on the ring could make."""
        basis = self._of_moments
        along = np.einsum("nki,nk->ni", basis, forces)
        return forces - np.einsum("nki,ni->nk", basis, along)

    @cached_property
    def _forces_of(self) -> np.ndarray:
        """Leg forces of unit wrenches, J^-T (N, 6, 6)."""
        return np.linalg.inv(np.transpose(self.jacobians, (0, 2, 1)))

    @cached_property
    def _of_moments(self) -> np.ndarray:
        """Orthonormal leg forces that moments alone make (N, 6, 3)."""
        return np.linalg.qr(self._forces_of[:, :, 3:])[0]

    @cached_property
    def leg_rates(self) -> np.ndarray:
        """Rates of the leg lengths (N, 6), m/s."""
        return np.einsum("nij,nj->ni", self.jacobians, self.velocities)


def follow_ring(
    numbers: BenchNumbers, x: np.ndarray, rate: float, cutoff_hz: float
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
        jacobians,
        slow[:, LENGTHS],
        slow[:, COMMANDS],
        slow[:, FORCE],
    )


def slope(values: np.ndarray, rate: float) -> np.ndarray:
    """Derivative of samples (N, ...) by time, of a cubic spline through them.

    Differences of neighbours lose a third of what is at half of the highest
    frequency, a spline a twentieth.
    """
    times = np.arange(len(values)) / rate
    return CubicSpline(times, values)(times, 1)


def calc_imbalance(
    numbers: BenchNumbers, way: RingWay, touches: bool
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
    wrench[:, 2] += numbers.ring[4]
    if touches:
        wrench[:, 0:3] += way.force
    asked = way.leg_forces(wrench) + numbers.viscous * way.leg_rates
    lack = way.commands - asked
    return way.beyond_moments(lack) if touches else lack
