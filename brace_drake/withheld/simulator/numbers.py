"""Numbers of the bench as its data sheet gives them. SI units."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

TICK = 1e-3  # s, period of the controller
STEPS = 10  # of the integration in a tick: 0.1 ms
LOG_EVERY = 5  # ticks: 200 Hz
GRAVITY = 9.81  # m/s^2

RING_MASS = 0.85  # kg
RING_INERTIA = np.array([0.0105, 0.0105, 0.0205])  # kg m^2 about R2
RING_HEIGHTS = (0.145, 0.235)  # m, clamped and moving ring

LEG_VISCOUS = 40.0  # N s/m
LEG_LIMIT = 120.0  # N
SCREW_RADII = (0.190, 0.180)  # m, of the lower and upper joint circles
LOWER_ANGLES = (-13.0, 13.0, 107.0, 133.0, 227.0, 253.0)  # deg
UPPER_ANGLES = (-47.0, 47.0, 73.0, 167.0, 193.0, 287.0)  # deg

TORSO_INERTIA = np.array([1.05, 0.95, 0.42])  # kg m^2 about T
POSTURE = np.array([2500.0, 1800.0, 20000.0, 180.0, 180.0, 90.0])
POSTURE_DAMPING = np.array([250.0, 220.0, 600.0, 12.0, 12.0, 8.0])

PAD_OFFSET = 0.15  # m, of both pads along y
PAD_FRICTION = 0.35
PAD_SLIP_SPEED = 0.005  # m/s, where friction is 76 % of its full value

KP, KD = 1600.0, 80.0
CUTOFF_HZ = 40.0
FORCE_TAU = 0.02  # s
DESIRED_MASS = 2.0  # kg
DESIRED_STIFFNESS = 6000.0  # N/m
DESIRED_DAMPING = 2.0 * np.sqrt(DESIRED_MASS * DESIRED_STIFFNESS)

LENGTH_NOISE, LENGTH_STEP = 5e-6, 1e-5  # m
FORCE_NOISE, FORCE_STEP = 0.03, 100.0 / 4096.0  # N
MARKER_NOISE = 5e-5  # m


class Subject(NamedTuple):
    """The subject, and how tight the brace sits."""

    stiffness: float = 6400.0  # N/m, of each pad's tissue
    damping: float = 150.0  # N s/m
    posture_stiffness: float = 1800.0  # N/m along y
    posture_damping: float = 220.0  # N s/m
    torso_mass: float = 40.0  # kg
    preload: float = 0.001  # m of compression of each pad at rest


def joint_circle(radius: float, angles: tuple, height: float) -> np.ndarray:
    """Joints on a horizontal circle, (6, 3), m."""
    a = np.radians(angles)
    z = np.full(6, height)
    return np.column_stack([radius * np.cos(a), radius * np.sin(a), z])


def lower_joints() -> np.ndarray:
    """Lower anchors in W, (6, 3), m."""
    return joint_circle(SCREW_RADII[0], LOWER_ANGLES, RING_HEIGHTS[0])


def upper_joints() -> np.ndarray:
    """Upper anchors in the moving ring's frame, (6, 3), m."""
    return joint_circle(SCREW_RADII[1], UPPER_ANGLES, 0.0)
