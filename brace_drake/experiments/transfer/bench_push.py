"""A policy, or a constant, on the independent simulator of the bench."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.experiments.scores import Push
from brace_drake.learning.diagram_loop import MakeCubic
from brace_drake.learning.policy import Policy
from brace_drake.withheld.simulator import (
    TICK,
    Decisions,
    Flaws,
    Run,
    Subject,
    control,
    run_bench,
)


def cubic_push(way: float, duration: float) -> np.ndarray:
    """The paper's reference y, y', y'' at control ticks (ticks, 3)."""
    motion = MakeCubic(np.zeros(1), np.full(1, way), duration)
    time = TICK * np.arange(round(duration / TICK) + 1)
    return np.ascontiguousarray(motion.vector_values(time).T)


def push_bench(
    subject: Subject,
    flaws: Flaws,
    policy: Policy | None,
    way: float = -0.01,
    duration: float = 12.0,
    seed: int | Sequence[int] = 0,
    noise: bool = True,
) -> Push:
    """Pushes the subject of an independent simulator; rows are decisions.

    Positions and rates are those of the ring itself, the force is as the
    sensor behind its filter has it.

    Args:
        subject, flaws: Of the simulator.
        policy: Sees what the simulator's own controller has measured; None:
            the data sheet's constant stiffness.
        way: m.
        duration: Of the push, s.
        seed: Of all that is random in the machine, one number or several.
        noise: Of its instruments.
    """
    every = 50 if policy is None else round(policy.task.sample_time / TICK)
    wanted = cubic_push(way, duration)
    rows: list[list[float]] = []
    held = None if policy is None else policy.law.action(policy.law.start)

    def decide(tick: int, run: Run) -> float:
        nonlocal held
        stiffness = run.memory[control.STIFFNESS]
        if policy is not None:
            action = policy.act_on(*_known(run.memory, wanted[tick]))
            held = policy.law.limit(action, held)
            stiffness = float(policy.law.stiffness(held)[0])
        X, rate = run.x[0:3], run.memory[control.RATE + 1]
        force = run.memory[control.FORCE]
        y, y_rate = wanted[tick, 0:2]
        error = y - X[1], -X[0], -X[2]
        rows.append([tick * TICK, *error, y_rate - rate, force, stiffness])
        return stiffness

    rng = np.random.default_rng(seed)
    decisions = Decisions(every, decide)
    run_bench(wanted, True, subject, flaws, rng, noise, decisions=decisions)
    time, *errors, rate, force, stiffness = np.transpose(rows)
    error = np.stack(errors, axis=1)
    # The ring hangs where gravity has taken it.
    error[:, 2] -= error[0, 2]
    return Push(time, error, rate, force, stiffness)


def _known(
    memory: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What the machine's controller knows, and the reference along y.

    X, X', filtered force on the torso (18,) and X_d, X_d', X_d'' (18,).
    """
    estimate, desired = np.zeros((3, 6)), np.zeros((3, 6))
    estimate[0] = memory[control.POSE : control.POSE + 6]
    estimate[1] = memory[control.RATE : control.RATE + 6]
    estimate[2, 1] = memory[control.FORCE]
    desired[:, 1] = wanted
    return estimate.ravel(), desired.ravel()
