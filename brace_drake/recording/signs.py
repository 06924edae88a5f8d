"""Does a force agree in sign with the motion that it causes?"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from brace_drake.recording.columns import BENCH, BRACE, LEG_BENCH, PAD_BENCH
from brace_drake.recording.findings import error
from brace_drake.recording.recording import Problem
from brace_drake.recording.table import Columns

_WINDOW_S = 0.05
_ABOVE_NOISE = 3.0
# The wrong sign is reported when it explains most of the force and the right
# one less than half of that. Recordings of sound sensors stay far away: there
# the wrong sign explains less than a fifth.
_EXPLAINED = 0.5
_BEATEN = 0.5
# Below this the torso's spring outweighs its mass: 4.6 rad/s is the lowest
# resonance to expect, of 60 kg on 1260 N/m.
_QUASI_STATIC_RAD_S = 3.5
# Half the weight of the bench's moving ring, N.
_HALF_RING_WEIGHT = 0.5 * 0.85 * 9.81


def check_signs(
    device: str | None,
    columns: Columns,
    rate_hz: float,
    contact: bool,
    file: str,
) -> list[Problem]:
    """Force signs of one run that contradict the motion.

    Args:
        device: A key of DEVICES.
        columns: All its channels, finite, each of shape (N,).
        rate_hz: Sampling rate.
        contact: Whether the torso is there.
        file: The recording's name.
    """
    if device in (BENCH, BRACE):
        found = _check_legs(columns, file)
        return found + _check_ring(columns, rate_hz, file) if contact else found
    if device == LEG_BENCH:
        return _check_drive(columns, rate_hz, file)
    if device == PAD_BENCH:
        return _check_pad(columns, rate_hz, file)
    return []


def smoothed(values: np.ndarray, rate_hz: float) -> np.ndarray:
    """Triangular running mean over 0.1 s, without the ends; from (N,)."""
    width = max(1, round(_WINDOW_S * rate_hz))
    if values.size < 4 * width:
        return values
    box = np.ones(width) / width
    return np.convolve(values, np.convolve(box, box), mode="valid")


def moves(values: np.ndarray, rate_hz: float) -> bool:
    """Whether a channel moves clearly above its own noise."""
    noise = np.std(np.diff(values)) / np.sqrt(2.0)
    motion = np.std(smoothed(values, rate_hz))
    return bool(motion > max(_ABOVE_NOISE * noise, 1e-12))


def explained(force: np.ndarray, terms: np.ndarray) -> float:
    """Share of a force's variance that a passive body accounts for.

    Args:
        force: Force on the body, shape (N,).
        terms: Motions whose factors cannot be negative (displacement,
            velocity, acceleration), shape (N, n).

    Returns:
        0.0 when no spring, damper or mass helps, 1.0 when they say all.
    """
    force = force - force.mean()
    terms = terms - terms.mean(axis=0)
    scale = np.linalg.norm(terms, axis=0)
    terms = terms[:, scale > 0] / scale[scale > 0]
    total = float(force @ force)
    if total == 0.0 or terms.shape[1] == 0:
        return 0.0
    basis, small = np.linalg.qr(terms)
    factors, _ = nnls(small, basis.T @ force)
    rest = force - terms @ factors
    return 1.0 - float(rest @ rest) / total


def opposes(force: np.ndarray, terms: np.ndarray) -> bool:
    """Whether the negative of a force, but not the force, moves the body."""
    wrong = explained(-force, terms)
    return wrong > _EXPLAINED and explained(force, terms) < _BEATEN * wrong


def _derivatives(motion: np.ndarray, rate_hz: float) -> np.ndarray:
    """Displacement, velocity and acceleration side by side, shape (N, 3)."""
    velocity = np.gradient(motion) * rate_hz
    return np.column_stack([motion, velocity, np.gradient(velocity) * rate_hz])


def _is_mirrored(motion: np.ndarray, reference: np.ndarray) -> bool:
    return float((motion - motion.mean()) @ (reference - reference.mean())) < 0


def _check_legs(columns: Columns, file: str) -> list[Problem]:
    """The legs push apart to carry the ring's weight."""
    names = [name for name in columns if name.endswith("_force_command_N")]
    total = sum(float(columns[name].mean()) for name in names)
    if total > -_HALF_RING_WEIGHT:
        return []
    message = (
        f"wrong sign: the leg commands sum to {total:.3g} N on average, but "
        f"positive ones carry the ring"
    )
    return [error(file, message)]


def _check_ring(columns: Columns, rate_hz: float, file: str) -> list[Problem]:
    """A ring that moves the torso pushes it where it goes.

    Runs in which the torso moves by itself say nothing: there the ring
    resists. They are left out by asking that the reference moves as much.
    """
    rings = [i for i in (1, 2, 3) if f"ring{i}_force_y_N" in columns]
    force = sum(columns[f"ring{i}_force_y_N"] for i in rings)
    torso = columns["torso_y_m"]
    if not (moves(force, rate_hz) and moves(torso, rate_hz)):
        return []
    force, torso = smoothed(force, rate_hz), smoothed(torso, rate_hz)
    references = [
        smoothed(columns[f"ring{i}_y_desired_m"], rate_hz) for i in rings
    ]
    reference = max(references, key=np.std)
    if np.std(reference) < 0.5 * np.std(torso):
        return []
    terms = _derivatives(torso, rate_hz)
    slow = np.std(terms[:, 1]) < _QUASI_STATIC_RAD_S * np.std(terms[:, 0])
    # A mass passes for a spring of the wrong sign: in a slow motion, where
    # the true mass does not count, it is also tried without.
    if not (opposes(force, terms) or (slow and opposes(force, terms[:, :2]))):
        return []
    if _is_mirrored(torso, reference):
        message = "wrong sign: the torso moves against the force and the ring"
        return [error(file, message, "torso_y_m")]
    message = "wrong sign: the force opposes the torso's motion that it causes"
    column = "ring2_force_y_N" if rings == [2] else None
    return [error(file, message, column)]


def _check_drive(columns: Columns, rate_hz: float, file: str) -> list[Problem]:
    """A drive's force accelerates it and overcomes its friction."""
    force = columns["force_command_N"]
    position = columns["position_m"]
    if not (moves(force, rate_hz) and moves(position, rate_hz)):
        return []
    force = smoothed(force, rate_hz)
    position = smoothed(position, rate_hz)
    _, velocity, acceleration = _derivatives(position, rate_hz).T
    direction = np.tanh(velocity / max(np.std(velocity), 1e-12) * 3.0)
    terms = np.column_stack([velocity, acceleration, direction])
    alone = _is_alone(columns, rate_hz)
    if not opposes(force[alone], terms[alone]):
        return []
    desired = columns.get("position_desired_m")
    if desired is not None and _is_mirrored(
        position, smoothed(desired, rate_hz)
    ):
        message = "wrong sign: the drive moves against force and reference"
        return [error(file, message, "position_m")]
    message = "wrong sign: the force opposes the motion that it causes"
    return [error(file, message, "force_command_N")]


def _is_alone(columns: Columns, rate_hz: float) -> np.ndarray:
    """Marks of the smoothed samples without a known load.

    Where the load acts it may be part of the command or not. A load that
    never rests leaves no choice: then every sample is marked.
    """
    load = columns.get("external_force_N", np.zeros_like(columns["time_s"]))
    alone = smoothed(np.abs(load), rate_hz) < 1e-9
    return alone if alone.mean() > 0.1 else np.ones_like(alone)


def _check_pad(columns: Columns, rate_hz: float, file: str) -> list[Problem]:
    """Tissue that is pressed inward presses back."""
    force, depth = columns["force_N"], columns["displacement_m"]
    if not (moves(force, rate_hz) and moves(depth, rate_hz)):
        return []
    depth = smoothed(depth, rate_hz)
    terms = _derivatives(depth, rate_hz)[:, :2]
    if not opposes(smoothed(force, rate_hz), terms):
        return []
    message = "wrong sign: the force falls when the pad is pressed inward"
    return [error(file, message, "force_N")]
