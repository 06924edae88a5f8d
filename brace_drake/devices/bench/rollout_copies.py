"""Compiled runs of several machines side by side."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.bench.rollout import Motion, simulate_bench
from brace_drake.laws.control.brace_control import (
    PIC,
    Controller,
    make_controller,
    start_held,
)
from brace_drake.laws.lanes.arrays import stack_copies
from brace_drake.laws.lanes.kinds import COUNT
from brace_drake.laws.loop.brace import Brace, make_brace
from brace_drake.laws.loop.rollout_copies import rollout_copies
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import PlugIn, make_effects_of

# Fields of a controller that go on from tick to tick.
_REMEMBERED = (
    "rings", "memory", "virtual", "impedance", "poses", "state", "desired", "F",
)  # fmt: skip


class Begun(NamedTuple):
    """Where a run has come to: of COUNT copies that are alike.

    Attributes:
        brace: At a tick, see `laws.loop.brace.Brace`.
        controller: Before that tick.
    """

    brace: Brace
    controller: Controller


class MachineRun(NamedTuple):
    """A machine and what it is asked to do.

    Attributes:
        numbers, plug_ins: Of the machine, see `simulate_bench`.
        motion, noise: Of the run, as there.
    """

    numbers: BraceNumbers
    plug_ins: Mapping[str, PlugIn]
    motion: Motion
    noise: np.ndarray | None = None


def begin_run(run: MachineRun, time_step: float) -> Begun:
    """Where a machine stands at the last tick of a motion.

    Its brace at that tick and its controller before it: what goes on from
    there reads at that tick once more and answers it, as if nothing had been
    between.

    Args:
        run: Two ticks or more.
        time_step: As `simulate_bench` takes it.

    Raises:
        BraceError: The run broke down.
    """
    before = run._replace(
        motion=replace(run.motion, desired=run.motion.desired[:-1])
    )
    found = [_run([r], time_step) for r in (before, run)]
    if any(one is None for one in found):
        raise BraceError("the simulated run broke down")
    (_, earlier), (_, there) = found
    return Begun(there.brace, earlier.controller)


def simulate_copies(
    runs: Sequence[MachineRun],
    time_step: float,
    begun: Begun | None = None,
) -> list[np.ndarray | None]:
    """`simulate_bench` of several machines of one kind, each what it is alone.

    They go side by side: four take little longer than one.

    Args:
        runs: Machines, alike in the number of rings, period and resolution.
        time_step: As there.
        begun: Where all of them go on from; None: from rest. What they do there
            is at their time 0, and their effects begin there.

    Returns:
        The log of each; None where its run broke down.
    """
    alike: dict[Hashable, list[int]] = {}
    for i, run in enumerate(runs):
        alike.setdefault(_kind_of(run), []).append(i)
    logs: list[np.ndarray | None] = [None] * len(runs)
    for places in alike.values():
        # A run waits for the longest beside it.
        places.sort(key=lambda i: len(runs[i].motion.desired))
        for at in range(0, len(places), COUNT):
            few = places[at : at + COUNT]
            found = _side_by_side([runs[i] for i in few], time_step, begun)
            for i, log in zip(few, found, strict=True):
                logs[i] = log
    return logs


def _kind_of(run: MachineRun) -> Hashable:
    """What is the same in runs that go side by side."""
    motion = run.motion
    return (
        motion.with_torso,
        motion.ticks_per_sample,
        motion.columns,
        run.noise is None,
    )


def _side_by_side(
    runs: Sequence[MachineRun], time_step: float, begun: Begun | None
) -> list[np.ndarray | None]:
    """Up to COUNT runs of a kind."""
    if len(runs) > 1:
        found = _run(runs, time_step, begun)
        if found is not None:
            return list(found[0])
    # Alone, or one broke down.
    return [_alone(run, time_step, begun) for run in runs]


def _alone(
    run: MachineRun, time_step: float, begun: Begun | None
) -> np.ndarray | None:
    if begun is not None:
        found = _run([run], time_step, begun)
        return None if found is None else found[0][0]
    numbers, plug_ins, motion, noise = run
    try:
        return simulate_bench(numbers, motion, time_step, plug_ins, noise)
    except BraceError:
        return None


def _run(
    runs: Sequence[MachineRun], time_step: float, begun: Begun | None = None
) -> tuple[list[np.ndarray], Begun] | None:
    """Logs of all runs and where they end, or None where one broke down."""
    first, motion = runs[0].numbers, runs[0].motion
    n, size = first.num_stages, len(first.noise_sigma)
    steps, every = round(first.period / time_step), motion.ticks_per_sample
    ticks = max(len(run.motion.desired) for run in runs)
    samples = max(run.motion.rows.stop for run in runs)
    log = np.zeros((samples, 6 * n + size + len(motion.columns), COUNT))
    brace, controller = _start(runs, begun)
    good = rollout_copies(
        first.period / steps,
        steps,
        stack_copies([run.numbers for run in runs]),
        make_effects_of([run.plug_ins for run in runs], n, COUNT),
        brace,
        controller,
        (
            _stack_ticks([run.motion.ways for run in runs], ticks),
            np.array(motion.columns, dtype=np.int64),
            _stack_noise(runs, ticks, size),
            every,
        ),
        log,
    )
    if not good:
        return None
    logs = [log[run.motion.rows, :, i].copy() for i, run in enumerate(runs)]
    return logs, Begun(brace, controller)


def _start(
    runs: Sequence[MachineRun], begun: Begun | None
) -> tuple[Brace, Controller]:
    """Stacked copies at rest, or where they have come to."""
    numbers = [run.numbers for run in runs]
    n, with_torso = numbers[0].num_stages, runs[0].motion.with_torso
    controller = stack_copies(
        [
            make_controller(
                PIC,
                m.control,
                start_held(m.start, m.rest, np.zeros((1, 6 * n))),
            )
            for m in numbers
        ]
    )
    if begun is None:
        return stack_copies(
            [make_brace(m, with_torso) for m in numbers]
        ), controller
    brace = Brace(*(part.copy() for part in begun.brace))
    # What it remembers goes on; its law is that of the machine's numbers.
    for name in _REMEMBERED:
        getattr(controller, name)[:] = getattr(begun.controller, name)
    return brace, controller


def _stack_noise(runs, ticks: int, size: int) -> np.ndarray:
    if runs[0].noise is None:
        return np.zeros((0, size, COUNT))
    return _stack_ticks([run.noise for run in runs], ticks)


def _stack_ticks(series: Sequence[np.ndarray], ticks: int) -> np.ndarray:
    """Series (own ticks, ...) as one (ticks, ..., COUNT), each held at its end;
    the last is repeated where there are fewer.
    """
    out = np.empty((ticks, *series[0].shape[1:], COUNT))
    for i in range(COUNT):
        own = series[min(i, len(series) - 1)]
        out[: len(own), ..., i] = own
        out[len(own) :, ..., i] = own[-1]
    return out
