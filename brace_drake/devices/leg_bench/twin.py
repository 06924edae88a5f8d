"""The leg bench's twin as fits and diagnoses see it."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.subject import SubjectParameter
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.stack import stack_effects
from brace_drake.laws.alone.leg_rollout import NUM_LOGGED, rollout_leg
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.recording.columns import LEG_BENCH
from brace_drake.recording.recording import Run
from brace_drake.scenario.leg_bench import (
    LegBenchNumbers,
    LegBenchScenario,
    pack_leg_bench,
)

CHANNELS = ("force_command_N", "position_m")
# Plug points that a leg has.
POINTS = ("drive", "sensing")

# Mass and viscous friction may be that many times less or more than nominal.
_SPREAD = 4.0
_OFFSET_LIMIT = 20.0  # N
_OFFSET_SCALE = 10.0  # N
# Stands for no limit of a command, N: a file holds finite numbers.
_NO_LIMIT = 1e12

# Samples from which the initial position and velocity are taken.
_START = 16


@dataclass(frozen=True)
class LegMotion:
    """What a run is asked to do, and from where it starts.

    Attributes:
        asked: At each tick: reference, m, force added to the command, N,
            further load on the drive, N (ticks, 3).
        state: Initial position, m, and velocity, m/s (2,).
        previous: The two readings before the run, newer first (2,), m.
        closed: Whether the position control acts; else the added force is
            the whole command.
        ticks_per_sample: Control periods in a logged sample.
    """

    asked: np.ndarray
    state: np.ndarray
    previous: np.ndarray
    closed: bool = True
    ticks_per_sample: int = 1


def simulate_leg(
    numbers: LegBenchNumbers,
    motion: LegMotion,
    time_step: float,
    plug_ins: Mapping[str, PlugIn] | None = None,
    noise: np.ndarray | None = None,
) -> np.ndarray:
    """Simulates one run with the compiled rollout.

    Args:
        numbers: The twin.
        motion: The run.
        time_step: Plant step, s; the control period is a multiple of it.
        plug_ins: Effects by plug point, those of POINTS count.
        noise: Of the reading at each tick (ticks,), m; None: exact readings.

    Returns:
        Log (samples, 2), columns CHANNELS.

    Raises:
        BraceError: The run broke down (the message says when).
    """
    given = plug_ins or {}
    plugs = [given.get(point) or idle(point) for point in POINTS]
    control, period = numbers.control, numbers.control[3]
    if not motion.closed:
        control = np.array([0.0, 0.0, math.inf, period])
    steps_per_tick = round(period / time_step)
    ticks = len(motion.asked)
    log = np.zeros(((ticks - 1) // motion.ticks_per_sample + 1, NUM_LOGGED))
    broke_at = rollout_leg(
        period / steps_per_tick,
        steps_per_tick,
        motion.ticks_per_sample,
        motion.asked,
        numbers.mass,
        numbers.viscous,
        numbers.offset,
        control,
        np.zeros(0) if noise is None else noise,
        motion.state.copy(),
        motion.previous.copy(),
        *(p.laws for p in plugs),
        plugs[0].parameters,
        *(p.fresh_memory() for p in plugs),
        log,
    )
    if broke_at >= 0:
        raise BraceError(
            f"the simulated run broke down at {broke_at * period:.3f} s"
        )
    return log


class LegBenchTwin(ReplayTwin):
    """Replays recorded references on the compiled leg bench.

    Without a recorded reference, or without gains, the recorded command
    drives the bench in open loop; position then drifts with every error of
    the model and is the channel to be compared.
    """

    channels = CHANNELS
    device = LEG_BENCH
    has_loop = True

    def __init__(
        self, scenario: LegBenchScenario, time_step: float | None = None
    ):
        super().__init__(scenario, pack_leg_bench(scenario), time_step)
        self.subject = leg_subject(self.numbers)

    def coarse(self) -> LegBenchTwin:
        """The same twin: a run costs milliseconds as it is."""
        return self

    def scenario_of(self, subject: np.ndarray) -> LegBenchScenario:
        """The scenario with a drive's numbers, a copy."""
        out = copy.deepcopy(self.scenario)
        out.mass, out.viscous, out.offset = (float(v) for v in subject)
        limit = min(out.control.force_limit, _NO_LIMIT)
        out.control = replace(out.control, force_limit=limit)
        return out

    def with_subject(self, values: np.ndarray) -> LegBenchNumbers:
        """The numbers of a drive, values in the order of `subject`."""
        mass, viscous, offset = (np.array([float(v)]) for v in values)
        return self.numbers.with_changes(
            mass=mass, viscous=viscous, offset=offset
        )

    def motion(self, run: Run) -> LegMotion:
        """The run's reference and loads at control ticks, and its start."""
        time, period = run.time_s - run.time_s[0], self.numbers.control[3]
        ticks = round(time[-1] / period) + 1
        at = np.minimum(np.arange(ticks) * period, time[-1])
        closed = self.is_closed(run)
        external = run.channels.get("external_force_N", np.zeros(len(time)))
        asked = np.zeros((ticks, 3))
        if not closed:
            asked[:, 1] = np.interp(at, time, run.channels["force_command_N"])
        else:
            desired = run.channels["position_desired_m"]
            column = 1 if self.command_holds_external(run) else 2
            asked[:, 0] = np.interp(at, time, desired)
            asked[:, column] = np.interp(at, time, external)
        return LegMotion(
            asked,
            *self._start(run, asked),
            closed,
            max(1, round(np.median(np.diff(time)) / period)),
        )

    def _start(self, run: Run, asked: np.ndarray):
        """Initial state, and the two readings before it."""
        time, position = run.time_s - run.time_s[0], run.channels["position_m"]
        command, closed = run.channels["force_command_N"], self.is_closed(run)
        period, mass = self.numbers.control[3], self.numbers.mass[0]
        state = initial_state(time, position, command / mass)
        previous = state[0] - state[1] * period * np.array([1.0, 2.0])
        limit = self.numbers.control[2]
        if closed and np.all(np.abs(command[:2]) < limit):
            kp, kv = self.numbers.control[:2]
            # The velocities that the first two commands were made with.
            rest = asked[:2, 0] - position[:2], command[:2] - asked[:2, 1]
            velocity = kp * rest[0] - rest[1] / kv
            previous = (position[:2] - 2.0 * period * velocity)[::-1].copy()
        return state, previous

    def is_closed(self, run: Run) -> bool:
        """Whether a position control acts on a run's reference."""
        return (
            self.numbers.is_closed_loop and "position_desired_m" in run.channels
        )

    def command_holds_external(self, run: Run) -> bool:
        """Whether the recorded command contains the external force.

        It does where that leaves less between the command and the control
        law; elsewhere the external force is a load beside the command.
        """
        external = run.channels.get("external_force_N")
        if external is None or not self.is_closed(run):
            return True
        rest = run.channels["force_command_N"] - self.control_law(run)
        return bool(np.nanstd(rest - external) <= np.nanstd(rest))

    def control_law(self, run: Run) -> np.ndarray:
        """Commands of the control law for the recorded positions (N,), N.

        NaN at the first two samples, whose velocity is not known.
        """
        kp, kv = self.numbers.control[:2]
        y, step = run.channels["position_m"], np.median(np.diff(run.time_s))
        velocity = np.full(len(y), np.nan)
        velocity[2:] = (y[2:] - y[:-2]) / (2.0 * step)
        return kv * (kp * (run.channels["position_desired_m"] - y) - velocity)

    def active(self, run: Run) -> np.ndarray:
        """Which channels carry information in a run, bool (2,).

        In closed loop the command alone: the control law makes the position
        a linear function of it. In open loop the command is an input.
        """
        closed = self.is_closed(run)
        return np.array([closed, not closed])

    def _replay(self, numbers, motion, subject, uses, generator):
        noise = None
        if generator is not None:
            draws = generator.standard_normal(len(motion.asked))
            noise = draws * numbers.noise_sigma[0]
        plug_ins = stack_effects(uses)
        return simulate_leg(numbers, motion, self.time_step, plug_ins, noise)


def leg_subject(numbers: LegBenchNumbers) -> tuple[SubjectParameter, ...]:
    """Subject parameters of the leg bench with nominal values and limits.

    The offset is a load of any origin, amplifier or gravity, that the command
    has to hold: m y'' = u - b y' - offset.
    """
    mass, b = numbers.mass[0], numbers.viscous[0]
    limit = _OFFSET_LIMIT
    return (
        SubjectParameter("mass_kg", "kg", mass, mass / _SPREAD, mass * _SPREAD),
        SubjectParameter("viscous_N_s_m", "N s/m", b, b / _SPREAD, b * _SPREAD),
        SubjectParameter(
            "offset_N", "N", numbers.offset[0], -limit, limit, _OFFSET_SCALE
        ),
    )


def initial_state(
    time: np.ndarray, position: np.ndarray, drive: np.ndarray
) -> np.ndarray:
    """Position, m, and velocity, m/s, at the first sample (2,).

    From the first samples, as motion under a constant acceleration and one
    proportional to the drive's: y_0 + v_0 t + a t^2 / 2 + c iint drive.

    Args:
        time: Sample times from 0 (N,), s.
        position: (N,), m.
        drive: Acceleration by the held command (N,), m/s^2.
    """
    n = min(_START, len(time))
    t, step = time[:n], np.diff(time[:n])
    speed = np.concatenate([[0.0], np.cumsum(drive[: n - 1] * step)])
    way = (speed[:-1] + 0.5 * drive[: n - 1] * step) * step
    way = np.concatenate([[0.0], np.cumsum(way)])
    basis = np.column_stack([np.ones(n), t, 0.5 * t**2, way])
    size = np.maximum(np.abs(basis).max(axis=0), 1e-30)
    found, *_ = np.linalg.lstsq(basis / size, position[:n], rcond=None)
    return (found / size)[:2]
