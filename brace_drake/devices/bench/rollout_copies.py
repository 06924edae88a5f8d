"""Compiled runs of several machines side by side."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence

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
from brace_drake.laws.loop.effect_calls import EffectsOfCopies
from brace_drake.laws.loop.rollout_copies import rollout_copies
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import PlugIn, make_effects

Machine = tuple[BraceNumbers, Mapping[str, PlugIn]]


def simulate_copies(
    machines: Sequence[Machine],
    motion: Motion,
    time_step: float,
    noise: np.ndarray | None = None,
) -> list[np.ndarray | None]:
    """`simulate_bench` of several machines, each what it is alone.

    Those with the same effects go side by side: four take little longer than
    one.

    Args:
        machines: Numbers and effects of each.
        motion, time_step: As there.
        noise: Of all of them; None: exact readings.

    Returns:
        The log of each; None where its run broke down.
    """
    logs: list[np.ndarray | None] = [None] * len(machines)
    for places in _alike(machines):
        for at in range(0, len(places), COUNT):
            few = places[at : at + COUNT]
            own = [machines[i] for i in few]
            found = _side_by_side(own, motion, time_step, noise)
            for i, log in zip(few, found, strict=True):
                logs[i] = log
    return logs


def _alike(machines: Sequence[Machine]) -> list[list[int]]:
    """Places of machines by their effects."""
    found: dict[Hashable, list[int]] = {}
    for i, (_, plug_ins) in enumerate(machines):
        parts = [
            (plug.point, plug.laws, tuple(p.shape for p in plug.parameters))
            for plug in plug_ins.values()
        ]
        found.setdefault(tuple(parts), []).append(i)
    return list(found.values())


def _side_by_side(
    machines: Sequence[Machine],
    motion: Motion,
    time_step: float,
    noise: np.ndarray | None,
) -> list[np.ndarray | None]:
    """Up to COUNT machines with the same effects."""
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
        _effects_of(machines),
        stack_copies([make_brace(m, motion.with_torso) for m in numbers]),
        stack_copies(controllers),
        (plan.desired, plan.columns, plan.noise, plan.ticks_per_sample),
        log,
    )
    if not good:
        return None
    log = log[motion.settled_ticks // motion.ticks_per_sample :]
    return [log[:, :, i].copy() for i in range(len(machines))]


def _effects_of(machines: Sequence[Machine]) -> EffectsOfCopies:
    each = [make_effects(plugs, m.num_stages) for m, plugs in machines]
    each += [each[-1]] * (COUNT - len(each))
    memory = zip(*(e.memory for e in each), strict=True)
    return EffectsOfCopies(
        each[0].laws,
        _stack([e.parameters for e in each]),
        tuple(_stack(points) for points in memory),
        each[0].active,
        np.zeros((5, 12)),
    )


def _stack(copies: Sequence[Sequence[np.ndarray]]) -> tuple[np.ndarray, ...]:
    """Of each effect the arrays of all copies (COUNT, n, m)."""
    return tuple(np.stack(arrays) for arrays in zip(*copies, strict=True))
