"""Twins in which something begins in the middle of a run.

Until then all is nominal; from then on the subject's parameters and the effects
are those of a replay. That is what a fault does to a machine that is watched.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.bench.rollout import (
    Motion,
    draw_noise,
    smooth_rounding,
)
from brace_drake.devices.bench.rollout_copies import (
    Begun,
    MachineRun,
    begin_run,
    simulate_copies,
)
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.brace.twin import BraceTwin
from brace_drake.devices.twin import Request
from brace_drake.scenario.brace import BenchScenario, BraceScenario

# Beginnings that are kept: of a few onsets at a few plant steps.
_MOST = 6


@dataclass(frozen=True)
class OnsetMotion(Motion):
    """A motion in which something begins.

    Attributes:
        onset: Tick at which it does, a multiple of `ticks_per_sample`; logs
            begin there.
    """

    onset: int = 0

    def part(self, ticks: slice) -> Motion:
        """Some of its ticks."""
        return Motion(
            self.desired[ticks],
            self.with_torso,
            self.ticks_per_sample,
            columns=self.columns,
        )


class _Since(BenchTwin):
    """Replays from an onset on: motions are `OnsetMotion`."""

    def __init__(self, scenario, time_step: float | None = None):
        super().__init__(scenario, time_step)
        self._begun: OrderedDict[tuple[bytes, int], Begun] = OrderedDict()

    def simulate_each(self, requests):
        """Side by side where motion and onset are the same."""
        logs: list[np.ndarray | None] = [None] * len(requests)
        alike: dict[tuple[bytes, int], list[int]] = {}
        for i, request in enumerate(requests):
            key = request.motion.digest, request.motion.onset
            alike.setdefault(key, []).append(i)
        for places in alike.values():
            begun = self._begin(requests[places[0]].motion)
            runs = [self._run(requests[i]) for i in places]
            found = simulate_copies(runs, self.time_step, begun)
            for i, log in zip(places, found, strict=True):
                logs[i] = log
        return logs

    def simulate(self, motion, subject, uses=(), generator=None):
        """See `ReplayTwin.simulate`."""
        run = self._run(Request(motion, subject, uses), generator)
        begun = self._begin(motion)
        (log,) = simulate_copies([run], self.time_step, begun)
        if log is None:
            raise BraceError("the simulated run broke down")
        return log

    def _run(self, request: Request, generator=None) -> MachineRun:
        motion, subject, uses, seed = request
        numbers, every = self._machine(subject, uses)
        after = motion.part(slice(motion.onset, None))
        if seed is not None:
            generator = np.random.default_rng(seed)
        noise = None
        if generator is not None:
            numbers = smooth_rounding(numbers)
            noise = draw_noise(numbers, len(after.desired), generator)
        plug_ins = self._plug_ins(numbers, motion, every)
        return MachineRun(numbers, plug_ins, after, noise)

    def _begin(self, motion: OnsetMotion) -> Begun | None:
        """Where the nominal twin stands at the onset; None: at rest."""
        if motion.onset < 1:
            return None
        before = motion.part(slice(0, motion.onset + 1))
        key = before.digest, motion.onset
        if key not in self._begun:
            usual = np.array([p.nominal for p in self.subject])
            numbers, every = self._machine(usual, ())
            plug_ins = self._plug_ins(numbers, before, every)
            run = MachineRun(numbers, plug_ins, before)
            self._begun[key] = begin_run(run, self.time_step)
            while len(self._begun) > _MOST:
                self._begun.popitem(last=False)
        return self._begun[key]


class _BraceSince(_Since, BraceTwin):
    """The same of a whole brace."""


def MakeTwinSince(scenario: BraceScenario) -> BenchTwin:
    """The twin of a bench or a brace in which something begins in a run.

    Effects that the scenario carries begin anew at the onset; what is compared
    with such a replay is another one of the same onset.

    Raises:
        ScenarioError: What has no compiled law.
    """
    if isinstance(scenario, BenchScenario):
        return _Since(scenario)
    return _BraceSince(scenario)
