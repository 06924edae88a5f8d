"""When an episode ends: equations (17) to (19)."""

from dataclasses import dataclass, field

import numpy as np

from brace_drake.learning.signals import Signals, name_of

_NONE = np.inf


def _vector(*values: float):
    return field(default_factory=lambda: np.array(values, dtype=float))


@dataclass
class EpisodeLimits:
    """Beyond these an episode ends; of one ring (6,) or of all (6n,).

    The paper's, with its y < -0.4 m (where -0.04 m may have been meant: the
    legs' strokes end at 0.03 m).
    """

    lower: np.ndarray = _vector(-0.02, -0.4, -0.02, -_NONE, -_NONE, -_NONE)
    upper: np.ndarray = _vector(0.02, 0.006, 0.02, _NONE, _NONE, _NONE)
    speed: np.ndarray = _vector(_NONE, 0.6, _NONE, _NONE, _NONE, _NONE)
    force: np.ndarray = _vector(_NONE, 50.0, _NONE, _NONE, _NONE, _NONE)


def find_violation(
    signals: Signals, limits: EpisodeLimits, rings: tuple[str, ...]
) -> str:
    """The first limit that is passed, in words; "" where none is.

    Args:
        signals: All of (6n,).
        limits: The same.
        rings: Names, bottom to top.
    """
    X = signals.position
    checks = (
        (X > limits.upper, "position", X, "above", limits.upper),
        (X < limits.lower, "position", X, "below", limits.lower),
        _too_large("speed", signals.rate, limits.speed),
        _too_large("force", signals.force, limits.force),
    )
    for passed, what, values, how, limit in checks:
        if passed.any():
            i = int(np.argmax(passed))
            return (
                f"{name_of(i, rings)}: {what} {values[i]:.4g} {how}"
                f" {limit[i]:.4g}"
            )
    return ""


def _too_large(what: str, values: np.ndarray, limit: np.ndarray):
    return np.abs(values) > limit, what, values, "beyond +-", limit
