"""Do forces agree with the motion that they cause, and with contact?"""

from __future__ import annotations

import numpy as np

from brace_drake.recording.columns import (
    BENCH,
    BRACE,
    LEG_BENCH,
    PAD_BENCH,
)
from brace_drake.recording.findings import Problem, error, warning
from brace_drake.recording.samples import LEAST_STEP_S, TELLING_ROWS
from brace_drake.recording.table import Columns

_ABSURD = 1e9
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
# Half the weight of one moving ring, N.
_HALF_RING_WEIGHT = 0.5 * 0.85 * 9.81
# No sensor drifts so far in a run, N; a brace presses with more.
_PRESSES = 3.0


def check_forces(
    device: str, columns: Columns, contact: bool, file: str
) -> list[Problem]:
    """Forces of one run that contradict the motion or the contact.

    Only rows count in which every channel has a number.

    Args:
        device: A key of DEVICES.
        columns: Its channels, each of shape (N,).
        contact: Whether the torso is there.
        file: The recording's name.
    """
    # Written so that NaN fails.
    whole = np.all([np.abs(v) < _ABSURD for v in columns.values()], axis=0)
    if np.count_nonzero(whole) < TELLING_ROWS:
        return []
    columns = {name: values[whole] for name, values in columns.items()}
    period = float(np.median(np.diff(columns["time_s"])))
    if period < LEAST_STEP_S:
        return []
    rate_hz = 1.0 / period
    if device == LEG_BENCH:
        return _check_drive(columns, rate_hz, file)
    if device == PAD_BENCH:
        return _check_pad(columns, rate_hz, file)
    if device not in (BENCH, BRACE):
        return []
    return _check_stages(columns, rate_hz, contact, file)


def smoothed(values: np.ndarray, rate_hz: float) -> np.ndarray:
    """Triangular running mean over 0.1 s, without the ends; from (N,)."""
    width = max(1, round(_WINDOW_S * rate_hz))
    if values.size < 4 * width:
        return values
    box = np.ones(width) / width
    return np.convolve(values, np.convolve(box, box), mode="valid")


def explained(force: np.ndarray, terms: np.ndarray) -> float:
    """Share of a force's variance that a passive body accounts for.

    Args:
        force: Force on the body, shape (N,).
        terms: Motions whose factors cannot be negative (displacement,
            velocity, acceleration), shape (N, n).

    Returns:
        0.0 when no spring, damper or mass helps, 1.0 when they say all.
    """
    # The command line starts without it.
    from scipy.optimize import nnls

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


def _opposes(force: np.ndarray, terms: np.ndarray) -> bool:
    """Whether the negative of a force, but not the force, moves the body."""
    wrong = explained(-force, terms)
    return wrong > _EXPLAINED and explained(force, terms) < _BEATEN * wrong


def _moving(
    force: np.ndarray, motion: np.ndarray, rate_hz: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """A force and what it may move, both smoothed.

    Returns:
        The force (N,); displacement, velocity and acceleration side by side
        (N, 3). None where one does not change clearly above its own noise.
    """
    smooth = []
    for values in (force, motion):
        noise = np.std(np.diff(values)) / np.sqrt(2.0)
        smooth.append(smoothed(values, rate_hz))
        if not np.std(smooth[-1]) > max(_ABOVE_NOISE * noise, 1e-12):
            return None
    force, motion = smooth
    velocity = np.gradient(motion) * rate_hz
    terms = [motion, velocity, np.gradient(velocity) * rate_hz]
    return force, np.column_stack(terms)


def _is_mirrored(motion: np.ndarray, reference: np.ndarray) -> bool:
    return float((motion - motion.mean()) @ (reference - reference.mean())) < 0


def _check_stages(
    columns: Columns, rate_hz: float, contact: bool, file: str
) -> list[Problem]:
    """Legs that push apart to carry their rings, rings that push the torso."""
    problems = []
    commands = [name for name in columns if name.endswith("_force_command_N")]
    total = sum(float(columns[name].mean()) for name in commands)
    if total <= -_HALF_RING_WEIGHT:
        message = (
            f"wrong sign: the leg commands sum to {total:.3g} N on average,"
            " but positive ones carry the ring"
        )
        problems.append(error(file, message))
    if contact:
        return problems + _check_push(columns, rate_hz, file)
    for name in columns:
        if "_force_" not in name or name in commands:
            continue
        change = float(np.ptp(smoothed(columns[name], rate_hz)))
        if change > _PRESSES:
            message = (
                f"changes by {change:.1f} N in a run with contact: false; was"
                " the torso there?"
            )
            problems.append(warning(file, message, name))
    return problems


def _check_push(columns: Columns, rate_hz: float, file: str) -> list[Problem]:
    """Rings that move the torso push it where they go.

    Runs in which the torso moves by itself say nothing: there the rings
    resist. They are left out by asking that the reference moves as much.
    """
    pushes = [name for name in columns if name.endswith("_force_y_N")]
    force = sum(columns[name] for name in pushes)
    moving = _moving(force, columns["torso_y_m"], rate_hz)
    if moving is None:
        return []
    force, terms = moving
    torso = terms[:, 0]
    asked = [name for name in columns if name.endswith("_y_desired_m")]
    references = [smoothed(columns[name], rate_hz) for name in asked]
    reference = max(references, key=np.std)
    if np.std(reference) < 0.5 * np.std(torso):
        return []
    slow = np.std(terms[:, 1]) < _QUASI_STATIC_RAD_S * np.std(torso)
    # A mass passes for a spring of the wrong sign: in a slow motion, where
    # the true mass does not count, it is also tried without.
    if not (_opposes(force, terms) or (slow and _opposes(force, terms[:, :2]))):
        return []
    if _is_mirrored(torso, reference):
        message = "wrong sign: the torso moves against the force and the ring"
        return [error(file, message, "torso_y_m")]
    message = "wrong sign: the force opposes the torso's motion that it causes"
    return [error(file, message, pushes[0] if len(pushes) == 1 else None)]


def _check_drive(columns: Columns, rate_hz: float, file: str) -> list[Problem]:
    """A drive's force accelerates it and overcomes its friction."""
    moving = _moving(columns["force_command_N"], columns["position_m"], rate_hz)
    if moving is None:
        return []
    force, (position, velocity, acceleration) = moving[0], moving[1].T
    direction = np.tanh(velocity / max(np.std(velocity), 1e-12) * 3.0)
    terms = np.column_stack([velocity, acceleration, direction])
    alone = _is_alone(columns, rate_hz)
    if not _opposes(force[alone], terms[alone]):
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
    moving = _moving(columns["force_N"], columns["displacement_m"], rate_hz)
    if moving is None or not _opposes(moving[0], moving[1][:, :2]):
        return []
    message = "wrong sign: the force falls when the pad is pressed inward"
    return [error(file, message, "force_N")]
