"""What each block of the bench answers alone to its recorded inputs."""

from __future__ import annotations

from functools import partial

import numpy as np
import scipy

from brace_drake.devices.bench.control_law import replay_controller
from brace_drake.devices.bench.force_balance import (
    CUTOFF_HZ,
    MARGIN_S,
    calc_imbalance,
)
from brace_drake.devices.bench.recorded_motion import low_pass, ring_poses
from brace_drake.devices.bench.ring_way import follow_ring
from brace_drake.devices.bench.rollout import (
    CHANNELS,
    COMMANDS,
    FORCE,
    LENGTHS,
    MARKER,
    VIRTUAL,
)
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.declaration import BlockTest
from brace_drake.devices.subject import with_subject
from brace_drake.kinematics import BraceGeometry

# Channels along the push.
FORCE_Y = CHANNELS.index("ring2_force_y_N")
MARKER_Y = CHANNELS.index("torso_y_m")


def bench_tests(twin: BenchTwin, rate: float) -> list[BlockTest]:
    """Controller, actuation, mechanism, contact, torso and sensing.

    Args:
        twin: Whose nominal numbers the blocks have.
        rate: Of the recordings, Hz.
    """
    names = twin.channels
    return [
        BlockTest(
            "controller",
            "leg lengths, force, reference",
            "commands, virtual position",
            partial(residual_of_controller, twin, rate),
            (*names[COMMANDS], names[VIRTUAL]),
        ),
        BlockTest(
            "actuation",
            "commands, motion and force of the ring",
            "balance of the leg forces",
            partial(residual_of_actuation, twin.numbers, rate),
            names[COMMANDS],
        ),
        BlockTest(
            "mechanism",
            "rest pose of the ring",
            "leg lengths at rest",
            partial(residual_of_mechanism, twin.numbers),
        ),
        BlockTest(
            "contact",
            "motion of ring and torso",
            "force between them",
            partial(residual_of_contact, twin.numbers, rate),
            names[MARKER],
            ("contact_stiffness_N_m", "contact_damping_N_s_m", "preload_m"),
        ),
        BlockTest(
            "torso",
            "force on the torso",
            "motion of the torso",
            partial(residual_of_torso, twin.numbers, rate),
            names[MARKER],
            (
                "torso_mass_kg",
                "posture_stiffness_y_N_m",
                "posture_damping_y_N_s_m",
            ),
        ),
        BlockTest(
            "sensing",
            "no contact",
            "force reading",
            partial(residual_of_sensing, rate),
        ),
    ]


def residual_of_controller(
    twin: BenchTwin, rate: float, prepared, x: np.ndarray
):
    """Logged commands and virtual position minus the controller's."""
    out = replay_controller(twin, prepared.motion, rate, x)
    scale = prepared.floor.rms
    commands = low_pass(x[:, COMMANDS] - out[:, 0:6], CUTOFF_HZ, rate)
    virtual = (x[:, VIRTUAL] - out[:, 6]) / scale[VIRTUAL]
    residual = np.concatenate([(commands / scale[0]).ravel(), virtual])
    return lambda subject: residual


def residual_of_actuation(numbers, rate: float, prepared, x: np.ndarray):
    """Commands minus what the recorded motion and force ask for."""
    # The inner part, away from the ends that the low pass folds.
    edge = int(MARGIN_S * rate)
    way = follow_ring(numbers, x, rate, CUTOFF_HZ)
    imbalance = calc_imbalance(numbers, way, prepared.run.contact)
    residual = imbalance[edge:-edge].ravel()
    return lambda subject: residual


def residual_of_mechanism(numbers, prepared, x: np.ndarray):
    """First leg lengths minus those of the ring at rest."""
    geometry = BraceGeometry(numbers.lower, numbers.upper, numbers.rest)
    residual = x[0, LENGTHS] - geometry.rest_lengths
    return lambda subject: residual


def residual_of_contact(numbers, rate: float, prepared, x: np.ndarray):
    """Force along the push minus that of the pads at the recorded places."""
    if not prepared.run.contact:
        return None
    slow = low_pass(x, CUTOFF_HZ, rate)
    poses, _ = ring_poses(numbers, slow[:, LENGTHS])
    relative = poses[:, 1] - slow[:, MARKER_Y]
    speed = np.gradient(relative, 1.0 / rate)

    def residual(subject):
        law = with_subject(numbers, subject).contact[0]
        total = np.zeros(len(x))
        for s in (1.0, -1.0):
            d, d_dot = law[5] - s * relative, -s * speed
            N = np.where(d > 0.0, law[0] * d + law[1] * d_dot, 0.0)
            total -= s * np.maximum(N, 0.0)
        return slow[:, FORCE_Y] - total

    return residual


def residual_of_torso(numbers, rate: float, prepared, x: np.ndarray):
    """Marker along the push minus what the force makes of a torso."""
    if not prepared.run.contact:
        return None

    def residual(subject):
        changed = with_subject(numbers, subject)
        mass, stiffness, damping = (
            changed.torso[0],
            changed.posture[1],
            changed.posture[4],
        )
        system = ([1.0 / mass], [1.0, damping / mass, stiffness / mass])
        b, a, _ = scipy.signal.cont2discrete(system, 1.0 / rate, method="foh")
        predicted = scipy.signal.lfilter(np.ravel(b), a, x[:, FORCE_Y])
        return low_pass(x[:, MARKER_Y] - predicted, CUTOFF_HZ, rate)

    return residual


def residual_of_sensing(rate: float, prepared, x: np.ndarray):
    """Force that is read where there is nothing to press on."""
    if prepared.run.contact:
        return None
    residual = low_pass(x[:, FORCE], 1.0, rate).ravel()
    return lambda subject: residual
