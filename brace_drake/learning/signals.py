"""What rewards, limits and policies look at, as arrays over coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from brace_drake.laws.stages import calc_task_coordinates

AXES = ("x", "y", "z", "rx", "ry", "rz")


class Signals(NamedTuple):
    """The brace at one instant, each (6n,), or at N of them, each (N, 6n).

    SI units, ring by ring. The paper's F_ey has to reach +4 N while the ring
    pushes towards -y: it is the force of the torso on the ring, the opposite
    of what the force sensors (and equation (5)) count.

    Attributes:
        desired: X_d.
        desired_rate: X_d'.
        position: X, displacement from rest and rotation vector.
        rate: X'.
        force: Of the torso on each ring, N; torques are not measured: 0.
    """

    desired: np.ndarray
    desired_rate: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    force: np.ndarray


def stack_signals(instants: Sequence[Signals], coordinates: int) -> Signals:
    """Instants as rows (N, 6n); N may be 0."""
    arrays = np.array(instants).reshape(-1, len(Signals._fields), coordinates)
    return Signals(*arrays.transpose(1, 0, 2))


def name_of(index: int, rings: tuple[str, ...]) -> str:
    """Name of a coordinate, as in "ring2 y"."""
    return f"{rings[index // 6]} {AXES[index % 6]}"


def observe_stage(signals: Signals) -> np.ndarray:
    """The paper's seven: y_d, y_d', y, y', F_ey, x, z of the only ring."""
    along = [part[..., 1] for part in signals]
    X = signals.position
    return np.stack([*along, X[..., 0], X[..., 2]], axis=-1)


def observe_all(signals: Signals) -> np.ndarray:
    """X, X_d, X', X_d', F_e one after another (30n,), section 3."""
    desired, desired_rate, position, rate, force = signals
    parts = [position, desired, rate, desired_rate, force]
    return np.concatenate(parts, axis=-1)


OBSERVERS = {"stage": observe_stage, "all": observe_all}


def observation_size(kind: str, coordinates: int) -> int:
    """Size of an observation of 6n coordinates."""
    return 7 if kind == "stage" else 5 * coordinates


def signals_of_estimate(estimate: np.ndarray, desired: np.ndarray) -> Signals:
    """What a controller knows, as signals.

    Args:
        estimate: X, X', filtered force on the torso (18n,), or (N, 18n).
        desired: X_d, X_d', X_d'' (18n,), or (N, 18n).
    """
    m = estimate.shape[-1] // 3
    X, rate = estimate[..., 0:m], estimate[..., m : 2 * m]
    force = -estimate[..., 2 * m :]
    return Signals(desired[..., 0:m], desired[..., m : 2 * m], X, rate, force)


def calc_task_state(bodies: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """X and X' (2, 6n) of the rings themselves.

    Args:
        bodies: q, p of the rings and the torso, then [w; v] of each.
        rest: Positions of the rings at rest (n, 3), m.
    """
    n = len(rest)
    X = np.empty((2, 6 * n))
    calc_task_coordinates(bodies[: 7 * n].reshape((n, 7)), rest, X[0])
    V = bodies[7 * n + 7 : 13 * n + 7].reshape((n, 6))
    X[1] = V[:, [3, 4, 5, 0, 1, 2]].ravel()
    return X


def true_signals(
    desired: np.ndarray, X: np.ndarray, pad_force: np.ndarray
) -> Signals:
    """What is, whatever the instruments read.

    Args:
        desired: X_d, X_d', X_d'' (18n,), or (N, 18n).
        X: X and X' (2, 6n), or (N, 2, 6n), of the rings themselves.
        pad_force: Of the pads on the torso, of 3n numbers, N.
    """
    m = X.shape[-1]
    force = np.zeros((*X.shape[:-2], m // 6, 6))
    force[..., 0:3] = -pad_force.reshape(*X.shape[:-2], -1, 3)
    desired, X = desired.copy(), X.copy()
    return Signals(
        desired[..., 0:m],
        desired[..., m : 2 * m],
        X[..., 0, :],
        X[..., 1, :],
        force.reshape(*X.shape[:-2], m),
    )
