"""Compiled runs of several machines side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.bench.rollout import Motion, simulate_bench
from brace_drake.laws.control.brace_control import (
    PIC,
    make_controller,
    start_held,
)
from brace_drake.laws.lanes.arrays import stack_copies
from brace_drake.laws.lanes.kinds import COUNT
from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.rollout_copies import rollout_copies
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import PlugIn, make_effects_of

Machine = tuple[BraceNumbers, Mapping[str, PlugIn]]


def simulate_copies(
    machines: Sequence[Machine],
    motion: Motion,
    time_step: float,
    noise: np.ndarray | None = None,
) -> list[np.ndarray | None]:
    """`simulate_bench` of several machines, each what it is alone.

    They go side by side: four take little longer than one.

    Args:
        machines: Numbers and effects of each.
        motion, time_step: As there.
        noise: Of all of them; None: exact readings.

    Returns:
        The log of each; None where its run broke down.
    """
    logs: list[np.ndarray | None] = []
    for at in range(0, len(machines), COUNT):
        few = machines[at : at + COUNT]
        logs += _side_by_side(few, motion, time_step, noise)
    return logs


def _side_by_side(
    machines: Sequence[Machine],
    motion: Motion,
    time_step: float,
    noise: np.ndarray | None,
) -> list[np.ndarray | None]:
    """Up to COUNT machines."""
    if len(machines) > 1:
        logs = _run(machines, motion, time_step, noise)
        if logs is not None:
            return logs
    # Alone, or one broke down.
    return [_alone(*m, motion, time_step, noise) for m in machines]


def _alone(numbers, plug_ins, motion, time_step, noise) -> np.ndarray | None:
    try:
        return simulate_bench(numbers, motion, time_step, plug_ins, noise)
    except BraceError:
        return None


def _run(
    machines: Sequence[Machine],
    motion: Motion,
    time_step: float,
    noise: np.ndarray | None,
) -> list[np.ndarray] | None:
    """Logs of all machines, or None where one broke down."""
    first = machines[0][0]
    n, size = first.num_stages, len(first.noise_sigma)
    steps = round(first.period / time_step)
    samples = (len(motion.desired) - 1) // motion.ticks_per_sample + 1
    log = np.zeros((samples, 6 * n + size + len(motion.columns), COUNT))
    plan = motion.plan(np.zeros((0, size)) if noise is None else noise, log[0])
    numbers = [m for m, _ in machines]
    controllers = [
        make_controller(
            PIC, m.control, start_held(m.start, m.rest, np.zeros((1, 6 * n)))
        )
        for m in numbers
    ]
    good = rollout_copies(
        first.period / steps,
        steps,
        stack_copies(numbers),
        make_effects_of([plugs for _, plugs in machines], n, COUNT),
        stack_copies([make_brace(m, motion.with_torso) for m in numbers]),
        stack_copies(controllers),
        (plan.desired, plan.columns, plan.noise, plan.ticks_per_sample),
        log,
    )
    if not good:
        return None
    log = log[motion.settled_ticks // motion.ticks_per_sample :]
    return [log[:, :, i].copy() for i in range(len(machines))]
