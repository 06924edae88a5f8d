"""A policy, or a constant, on the independent simulator of the bench."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.laws import cubic
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

_COORDINATES = 6


@dataclass(frozen=True)
class PhysicalPush:
    """A push on the simulator at its decisions; N rows.

    Attributes:
        time: s.
        desired, desired_rate: Along y, m, m/s.
        position: Of the ring itself (N, 3), m.
        rate: Along y, m/s.
        force: On the torso along y, as the sensor behind its filter has it, N.
        stiffness: Desired, along y, N/m.
    """

    time: np.ndarray
    desired: np.ndarray
    desired_rate: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray


def cubic_push(way: float, duration: float, ticks: int) -> np.ndarray:
    """The paper's reference y, y', y'' at control ticks (ticks, 3)."""
    start, end, out = np.zeros(1), np.full(1, way), np.empty(3)
    wanted = np.empty((ticks, 3))
    for k in range(ticks):
        cubic.calc_cubic(k * TICK, duration, start, end, out)
        wanted[k] = out
    return wanted


def push_bench(
    subject: Subject,
    flaws: Flaws,
    policy: Policy | None,
    way: float = -0.01,
    duration: float = 12.0,
    seed: int | Sequence[int] = 0,
    noise: bool = True,
) -> PhysicalPush:
    """Pushes the wearer of an independent simulator.

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
    wanted = cubic_push(way, duration, round(duration / TICK) + 1)
    rows: list[list[float]] = []
    held = None if policy is None else policy.law.action(policy.law.start)

    def decide(tick: int, run: Run) -> float:
        nonlocal held
        stiffness = run.memory[control.STIFFNESS]
        if policy is not None:
            action = policy.act_on(
                estimate_of(run.memory), desired_of(wanted[tick])
            )
            held = policy.law.limit(action, held)
            stiffness = float(policy.law.stiffness(held)[0])
        rows.append(
            [
                tick * TICK,
                *wanted[tick, 0:2],
                run.x[0],
                run.x[1],
                run.x[2],
                run.memory[control.RATE + 1],
                run.memory[control.FORCE],
                stiffness,
            ]
        )
        return stiffness

    rng = np.random.default_rng(seed)
    decisions = Decisions(every, decide)
    run_bench(wanted, True, subject, flaws, rng, noise, decisions=decisions)
    table = np.array(rows)
    position = table[:, 3:6] - np.array([0.0, 0.0, table[0, 5]])
    return PhysicalPush(
        *table[:, 0:3].T, position, table[:, 6], table[:, 7], table[:, 8]
    )


def estimate_of(memory: np.ndarray) -> np.ndarray:
    """X, X', filtered force on the torso (18,) of the machine's controller."""
    estimate = np.zeros(3 * _COORDINATES)
    estimate[0:6] = memory[control.POSE : control.POSE + 6]
    estimate[6:12] = memory[control.RATE : control.RATE + 6]
    estimate[13] = memory[control.FORCE]
    return estimate


def desired_of(wanted: np.ndarray) -> np.ndarray:
    """X_d, X_d', X_d'' (18,) of a reference along y."""
    desired = np.zeros(3 * _COORDINATES)
    desired[1::6] = wanted
    return desired
