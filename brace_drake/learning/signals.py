"""What rewards, limits and policies look at, as arrays over coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

AXES = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class Signals:
    """One instant of the brace; all of shape (6n,), SI, ring by ring.

    Attributes:
        desired: X_d.
        desired_rate: X_d'.
        position: X, displacement from rest and rotation vector.
        rate: X'.
        force: Of the torso on each ring, N; torques are not measured: 0.

    The paper's F_ey has to reach +4 N while the ring pushes towards -y: it is
    the force of the torso on the ring, the opposite of what the force sensors
    (and equation (5)) count.
    """

    desired: np.ndarray
    desired_rate: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    force: np.ndarray


def name_of(index: int, rings: tuple[str, ...]) -> str:
    """Name of a coordinate, as in "ring2 y"."""
    return f"{rings[index // 6]} {AXES[index % 6]}"


def observe_stage(signals: Signals) -> np.ndarray:
    """The paper's seven: y_d, y_d', y, y', F_ey, x, z of the only ring."""
    return np.array(
        [
            signals.desired[1],
            signals.desired_rate[1],
            signals.position[1],
            signals.rate[1],
            signals.force[1],
            signals.position[0],
            signals.position[2],
        ]
    )


def observe_all(signals: Signals) -> np.ndarray:
    """X, X_d, X', X_d', F_e one after another (30n,), section 3."""
    return np.concatenate(
        [
            signals.position,
            signals.desired,
            signals.rate,
            signals.desired_rate,
            signals.force,
        ]
    )


OBSERVERS = {"stage": observe_stage, "all": observe_all}


def observation_size(kind: str, coordinates: int) -> int:
    """Size of an observation of 6n coordinates."""
    return 7 if kind == "stage" else 5 * coordinates


def signals_of_estimate(estimate: np.ndarray, desired: np.ndarray) -> Signals:
    """What a controller knows, as signals.

    Args:
        estimate: X, X', filtered force on the torso (18n,).
        desired: X_d, X_d', X_d'' (18n,).
    """
    X, rate, force = np.split(estimate, 3)
    m = len(X)
    return Signals(desired[0:m], desired[m : 2 * m], X, rate, -force)
