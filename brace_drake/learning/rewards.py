"""How a step is judged: the paper's reward, a better one, and its limits."""

from dataclasses import dataclass

import numpy as np

from brace_drake.learning.signals import Signals, name_of
from brace_drake.scenario.fields import number, vector, word

_NONE = np.inf


def _weights(*values: float):
    """A field of weights or coefficients, of one ring or of all."""
    return vector(*values, least=0.0, most=1e6, per_ring=6)


def _ends(*values: float, **limits):
    """A field of limits, of one ring or of all; infinite: there is none."""
    return vector(*values, or_infinite=True, per_ring=6, **limits)


@dataclass
class RewardNumbers:
    """Weights w and coefficients c of equations (7) to (10).

    Of one ring (6,), which all rings share, or of all (6n,). The defaults are
    equations (11) to (16).

    `kind` is one of

    paper     The sum of (7) as it stands. Its force term is largest *at* F_max
              and pays as little for a force far below as for one far above,
              and its half width of 0.17 N outweighs the position's of 10 mm: a
              policy is paid for pressing with 4 N, wherever the ring is.
    barrier   Position and velocity alike, best with coefficients to the scale
              of the errors that matter (`improved`). The force costs nothing
              below `barrier_share` of F_max, rises with the square to its
              weight at F_max and goes on in a line, so that one bad push does
              not outweigh all others: it keeps the force *below*. A change of
              stiffness costs `smoothness_weight` times the square of its share
              of the range: the paper's hope for a constant stiffness, said.
    """

    kind: str = word("paper", "barrier")
    position_weight: np.ndarray = _weights(2, 2, 2, 0, 0, 0)
    velocity_weight: np.ndarray = _weights(0, 2, 0, 0, 0, 0)
    force_weight: np.ndarray = _weights(0, 2, 0, 0, 0, 0)
    position_scale: np.ndarray = _weights(80, 80, 80, 80, 80, 80)  # 1/m, 1/rad
    velocity_scale: np.ndarray = _weights(80, 80, 80, 80, 80, 80)  # s/m
    force_scale: np.ndarray = _weights(5, 5, 5, 5, 5, 5)  # 1/N
    # F_max.
    force_limit: np.ndarray = vector(
        4, 4, 4, 4, 4, 4, unit="N", above=0.0, most=1e6, per_ring=6
    )
    barrier_share: float = number(0.8, least=0.0, most=0.999)
    smoothness_weight: float = number(0.0, least=0.0, most=1e6)


def improved() -> RewardNumbers:
    """The barrier, with coefficients to the scale of the paper's Table 1.

    An error of 0.4 mm along y, 0.2 mm along x or z, or 1 mm/s takes a term
    down to 1/e. A force of F_max costs 30 a step and all tracking brings 8, so
    that a policy keeps away from F_max on every subject, not on the average.
    """
    return RewardNumbers(
        kind="barrier",
        force_weight=np.array([0.0, 30, 0, 0, 0, 0]),
        position_scale=np.array([5000.0, 2500, 5000, 50, 50, 50]),
        velocity_scale=np.full(6, 1000.0),
        barrier_share=0.9,
        smoothness_weight=5.0,
    )


def bell(scale: np.ndarray, error: np.ndarray) -> np.ndarray:
    """exp(-(c error)^2), equations (8) to (10)."""
    return np.exp(-np.square(scale * error))


def barrier(force: np.ndarray, limit: np.ndarray, share: float) -> np.ndarray:
    """0 up to share F_max, with the square to -1 at F_max, on in a line."""
    over = np.maximum(0.0, np.abs(force) / limit - share) / (1.0 - share)
    return -np.where(over < 1.0, np.square(over), 2.0 * over - 1.0)


def calc_reward(
    signals: Signals, change: np.ndarray, numbers: RewardNumbers
) -> dict[str, np.ndarray]:
    """Terms of the reward by name, of each instant; the reward is their sum.

    Args:
        signals: After the step, of one instant or of N.
        change: Of each stiffness by the step's action, over its range, -1 to 1
            (k,), or (N, k).
        numbers: Of size (6n,).
    """
    force = (
        barrier(signals.force, numbers.force_limit, numbers.barrier_share)
        if numbers.kind == "barrier"
        else bell(numbers.force_scale, numbers.force_limit - signals.force)
    )
    position = bell(numbers.position_scale, signals.desired - signals.position)
    rate = bell(numbers.velocity_scale, signals.desired_rate - signals.rate)
    terms = {
        "position": _sum(numbers.position_weight * position),
        "velocity": _sum(numbers.velocity_weight * rate),
        "force": _sum(numbers.force_weight * force),
    }
    if numbers.kind == "barrier":
        cost = numbers.smoothness_weight * _sum(change * change)
        terms["smoothness"] = -cost
    return terms


def _sum(values: np.ndarray) -> np.ndarray:
    """Over coordinates, in one order: an instant gives the same bits alone."""
    return np.ascontiguousarray(values).sum(axis=-1)


@dataclass
class EpisodeLimits:
    """Beyond these an episode ends; of one ring (6,) or of all (6n,).

    Equations (17) to (19), with the paper's y < -0.4 m (where -0.04 m may have
    been meant: the legs' strokes end at 0.03 m).
    """

    lower: np.ndarray = _ends(-0.02, -0.4, -0.02, -_NONE, -_NONE, -_NONE)
    upper: np.ndarray = _ends(0.02, 0.006, 0.02, _NONE, _NONE, _NONE)
    speed: np.ndarray = _ends(_NONE, 0.6, _NONE, _NONE, _NONE, _NONE, above=0.0)
    force: np.ndarray = _ends(
        _NONE, 50.0, _NONE, _NONE, _NONE, _NONE, above=0.0
    )


def find_violation(
    signals: Signals, limits: EpisodeLimits, rings: tuple[str, ...]
) -> str:
    """The first limit that is passed, in words; "" where none is.

    Args:
        signals: All of (6n,).
        limits: The same.
        rings: Names, bottom to top.
    """
    for passed, what, values, how, limit in _passed(signals, limits):
        if passed.any():
            i = int(np.argmax(passed))
            return (
                f"{name_of(i, rings)}: {what} {values[i]:.4g} {how}"
                f" {limit[i]:.4g}"
            )
    return ""


def passes_limit(signals: Signals, limits: EpisodeLimits) -> np.ndarray:
    """Whether any limit is passed, of each instant."""
    rows = [passed.any(axis=-1) for passed, *_ in _passed(signals, limits)]
    return np.any(rows, axis=0)


def _passed(signals: Signals, limits: EpisodeLimits):
    """Rows of each limit: where it is passed, and the words for it."""
    X, rate, force = signals.position, signals.rate, signals.force
    return (
        (X > limits.upper, "position", X, "above", limits.upper),
        (X < limits.lower, "position", X, "below", limits.lower),
        (np.abs(rate) > limits.speed, "speed", rate, "beyond +-", limits.speed),
        (np.abs(force) > limits.force, "force", force, "beyond +-",
         limits.force),
    )  # fmt: skip
