"""What watching a device takes, from its twin and the cycle that it repeats."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import BraceError, ScenarioError
from brace_drake.devices.bench.rollout import Motion
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.brace.twin import BraceTwin
from brace_drake.devices.motions.library import SafeMotion
from brace_drake.devices.since import MakeTwinSince, OnsetMotion
from brace_drake.identification.noise_floor import NoiseFloor, estimate_floor
from brace_drake.identification.prepare import noise_replicates
from brace_drake.monitoring.causes import NamedCause, name_causes
from brace_drake.monitoring.detector import Thresholds, make_thresholds
from brace_drake.monitoring.noise_model import NoiseModel, fit_noise_model
from brace_drake.monitoring.watch import Since, Watch
from brace_drake.scenario.brace import BenchScenario, BraceScenario

# Samples of noise alone that its model takes, at least; s.
_NOISE = 720.0
# Below so little of it, s, nothing is told of what has begun.
LEAST = 1.0


@dataclass(frozen=True)
class Expected:
    """What is expected of a device on a cycle that it repeats.

    Attributes:
        scenario: Of the twin.
        cycle: The motion that is repeated.
        motion: The same at control ticks.
        rate: Of the samples, Hz.
        model, thresholds, floor: Of the noise.
        usual: Cycles at the beginning that are taken as usual.
    """

    scenario: BraceScenario
    cycle: SafeMotion
    motion: Motion
    rate: float
    model: NoiseModel
    thresholds: Thresholds
    floor: NoiseFloor
    usual: int

    def watch(self) -> Watch:
        """A watch at the beginning of the first cycle."""
        return Watch(
            self.model,
            self.thresholds,
            self.rate,
            len(self.cycle.time),
            self.usual,
            readings_of(self.scenario),
        )

    def motion_since(self, since: Since) -> OnsetMotion:
        """The motion from rest to the last of the rows."""
        motion, every = self.motion, self.motion.ticks_per_sample
        onset = since.onset - since.start
        ticks = (onset + len(since.rows)) * every
        count = -(-ticks // len(motion.desired))
        return OnsetMotion(
            np.concatenate([motion.desired] * count)[:ticks],
            motion.with_torso,
            every,
            columns=motion.columns,
            onset=onset * every,
        )


def readings_of(scenario: BraceScenario) -> slice:
    """Channels of a log that the device reads, not the host computes."""
    legs = 6 * len(scenario.stages)
    return slice(legs, 2 * legs + legs // 2 + 3)


def make_expected(
    scenario: BraceScenario,
    cycle: SafeMotion,
    usual: int,
    per_hour: float,
    seed: int = 0,
) -> Expected:
    """The noise of a twin on a cycle, simulated.

    Args:
        scenario: Of the twin, under position-based impedance control.
        cycle: From `close_cycle`.
        usual: Cycles at the beginning that are taken as usual; 0: the twin is
            expected.
        per_hour: False alarms in an hour, at most, in expectation.
        seed: Of the noise.

    Raises:
        ScenarioError: The controller has no compiled loop of its own.
        BraceError: The twin breaks down.
    """
    tag = scenario.control.tag
    if tag != "pic":
        raise ScenarioError(
            f"control.tag: {tag!r}; a device is watched under 'pic' alone"
        )
    kind = BenchTwin if isinstance(scenario, BenchScenario) else BraceTwin
    twin = kind(scenario)
    motion = twin.motion(cycle.run)
    rate = 1.0 / (motion.ticks_per_sample * twin.numbers.period)
    nominal = np.array([p.nominal for p in twin.subject])
    duration = len(cycle.time) / rate
    number = max(8, round(_NOISE / duration))
    seeds = [[seed, 7, k] for k in range(number)]
    noise = noise_replicates(twin, motion, nominal, (), seeds)
    floor = estimate_floor(noise, rate)
    if usual:
        floor = floor.scaled(np.full(noise.shape[2], 1.0 + 1.0 / usual))
    read = noise[:, :, readings_of(scenario)]
    model = fit_noise_model(read)
    first = model.lags[-1]
    white = np.array([model.whiten(n)[first:] for n in read])
    thresholds = make_thresholds(white, rate, per_hour)
    return Expected(
        scenario, cycle, motion, rate, model, thresholds, floor, usual
    )


class Namer:
    """Names what has begun, again and again as more is known of it."""

    def __init__(self, expected: Expected):
        self._expected = expected
        self._twin = MakeTwinSince(expected.scenario)
        self._effects = list(self._twin.effects().values())

    def WarmUp(self) -> None:
        """Loads laws and code with a question of no importance."""
        expected = self._expected
        size = round(2.0 * LEAST * expected.rate), len(expected.floor.rms)
        draw = np.random.default_rng(0)
        rows = draw.normal(0.0, 3.0 * expected.floor.rms, size)
        with contextlib.suppress(BraceError):
            self.Name(Since(0, 0, rows))

    def Name(self, since: Since) -> list[NamedCause]:
        """Causes, likeliest first; none while too little is known.

        Raises:
            BraceError: The twin breaks down.
        """
        expected = self._expected
        if len(since.rows) < LEAST * expected.rate:
            return []
        return name_causes(
            self._twin,
            expected.floor,
            expected.motion_since(since),
            since.rows,
            self._effects,
        )
