"""An axis that follows a commanded speed or position, or its own motor, as fits
see it.

Its recorded command is put in, or the motion of its motor. Under a command of
speed what it answers is compared as speed, since a position would drift with
every error of the model.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.axis.follower_subject import (
    fitted_fields,
    follower_subject,
)
from brace_drake.devices.pad_bench.twin import steps_per_sample
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.series import held_commands
from brace_drake.effects.stack import Use, stack_effects
from brace_drake.laws.alone.axis_response import (
    BIAS,
    NUMBERS,
    WORK,
    rollout_response,
)
from brace_drake.recording.columns import AXIS
from brace_drake.recording.recording import Run
from brace_drake.recording.ways import axis_columns, speed_column
from brace_drake.scenario.axis import AxisScenario

# Samples from which the first position and speed are taken, and those in which
# the machine does what it did before.
_START, _FIRST = 20, 3
# Samples at which the start has to be right.
_EARLY = 5
# Degree of the curve that the first samples lie on otherwise, and how many
# times more than it the follower may leave of them.
_BEND, _AS_WELL = 2, 1.5
# That long the command was the same before, s.
_BEFORE_S = 0.5


@dataclass(frozen=True)
class Commanded:
    """What a run is commanded, and from where it starts.

    Attributes:
        time: Sample times from 0 (N,), s.
        command: (N,), m/s or m.
        state: Position and speed at the start (2,).
        before: Command before the run.
    """

    time: np.ndarray
    command: np.ndarray
    state: np.ndarray
    before: float = 0.0


@dataclass(frozen=True)
class FollowerNumbers:
    """Law of a follower (8,), see `laws.alone.axis_response`, and the noise of
    a position reading.
    """

    law: np.ndarray
    noise: float


class AxisFollower(ReplayTwin):
    """Replays recorded commands on one axis that follows them."""

    device = AXIS
    has_loop = False
    finds_loop = True

    def __init__(self, scenario: AxisScenario, time_step: float | None = None):
        self.is_speed = scenario.command == "speed"
        self.is_commanded = scenario.command != "motor"
        self.position, self._command = axis_columns(
            scenario.kind, scenario.command
        )
        speed = speed_column(scenario.kind)
        self.has_speed = scenario.answer == "speed"
        if self.has_speed:
            self.position = speed
        self.channels = (speed if self.is_speed else self.position,)
        self.units = scenario.units
        super().__init__(scenario, _pack(scenario), time_step)
        self.subject = follower_subject(scenario)

    def coarse(self) -> AxisFollower:
        """The same twin: a run costs milliseconds as it is."""
        return self

    def scenario_of(self, subject: np.ndarray) -> AxisScenario:
        """The scenario with a machine's fitted numbers, a copy."""
        out = copy.deepcopy(self.scenario)
        for p, value in zip(fitted_fields(self.scenario), subject, strict=True):
            setattr(out, p, float(value))
        return out

    def with_subject(self, values: np.ndarray) -> FollowerNumbers:
        """The numbers of a machine, values in the order of `subject`."""
        return _pack(self.scenario_of(values))

    def motion(self, run: Run) -> Commanded:
        """The run's command and its start."""
        time = run.time_s - run.time_s[0]
        command = run.channels[self._command]
        y = run.channels[self.position]
        state = self._start(time[:_START], command[:_START], y[:_START])
        calm = self._answer(time, y)[:_FIRST]
        before = np.mean(calm) if self.is_speed else command[0]
        return Commanded(time, command, state, float(before))

    def _start(self, time, command, y) -> np.ndarray:
        """Position and speed from which the nominal follower comes nearest to
        the first samples (2,).
        """

        def positions(command, *state, bias=0.0):
            # Linear: any length will do.
            motion = Commanded(time, command, np.array(state))
            law = self.numbers.law.copy()
            law[BIAS] *= bias
            log = self._respond(law, motion, 1.0)
            return log[:, int(self.has_speed)]

        none = np.zeros(len(time))
        free = np.column_stack(
            [positions(none, 1.0, 0.0), positions(none, 0.0, 1.0)]
        )
        rest = y - positions(command, 0.0, 0.0, bias=1.0)
        size = np.maximum(np.linalg.norm(free, axis=0), 1e-30)
        state = np.linalg.lstsq(free / size, rest, rcond=None)[0] / size
        # A machine that friction holds, or a command that comes late, is no
        # such follower: then it rests, or the first samples lie on a curve.
        curve = np.polynomial.Polynomial.fit(time, y, min(_BEND, len(y) - 1))
        calm = np.array([np.mean(y[:_FIRST]), 0.0])
        moving = np.array([curve(0.0), curve.deriv()(0.0)])
        if self.has_speed:
            calm, moving = calm[::-1], np.array([0.0, moving[0]])
        left = np.array([rest - free @ state, y - np.mean(y[:_FIRST])])
        left = np.vstack([left, y - curve(time)])[:, :_EARLY]
        off = np.linalg.norm(left, axis=1)
        enough = max(self.numbers.noise * np.sqrt(left.shape[1]), off.min())
        place = int(np.argmax(off <= _AS_WELL * enough))
        return (state, calm, moving)[place]

    def measured(self, run: Run) -> np.ndarray:
        """Recorded position, or its rate (N, 1)."""
        y = run.channels[self.position]
        return np.array(self._answer(run.time_s, y))[:, None]

    def recorded(self, run: Run) -> np.ndarray:
        """Whether there is a position, which has the speed in it (1,)."""
        return run.has([self.position])

    def _answer(self, time: np.ndarray, position: np.ndarray) -> np.ndarray:
        is_derived = self.is_speed and not self.has_speed
        return np.gradient(position, time) if is_derived else position

    def _replay(self, numbers, motion, subject, uses, generator):
        length = self.units.length
        law = numbers.law.copy()
        law[BIAS] /= length
        mine = self.scenario.of_reference(uses)
        sent = [(e, v) for e, v in mine if "signal" in e.laws]
        if sent and self.is_commanded:
            command = self._arrived(motion, motion.command, sent)
            motion = replace(motion, command=command)
        mine = [(e, v) for e, v in mine if "signal" not in e.laws]
        log = self._respond(law, motion, length, mine)
        position = length * log[:, int(self.has_speed)]
        if sent and not self.is_commanded:
            position = self._arrived(motion, position, sent)
        if generator is not None:
            noise = generator.standard_normal(len(position))
            position = position + numbers.noise * noise
        return self._answer(motion.time, position)[:, None]

    def _respond(self, law, motion: Commanded, length: float, uses=()):
        step = self.time_step
        is_held = self.scenario.is_held and self.is_commanded
        return simulate_response(law, motion, length, step, uses, is_held)

    def _arrived(self, motion, signal, sent: Sequence[Use]) -> np.ndarray:
        """What arrives of a command, or of a reading, held from sample to
        sample (N,).
        """
        period = float(np.median(np.diff(motion.time)))
        before = motion.before if self.is_commanded else signal[0]
        before = np.full(max(1, round(_BEFORE_S / period)), before)
        given = np.concatenate([before, signal])[:, None]
        sizes = [self.scenario.command_size]
        arrived = held_commands(given, period, 1, sizes, {0: sent})
        return arrived[len(before) :, 0]

    def answer_noise(self, runs: Sequence[Run]) -> float:
        """Deviation that noise of the readings makes of what is compared."""
        time = runs[0].time_s
        noise = np.random.default_rng(0).standard_normal(len(time))
        ratio = float(np.std(self._answer(time, noise)))
        return ratio * self.numbers.noise


def simulate_response(
    law: np.ndarray,
    motion: Commanded,
    length: float,
    time_step: float,
    uses=(),
    is_held: bool = True,
) -> np.ndarray:
    """Simulates one run with the compiled rollout.

    Args:
        law: See `laws.alone.axis_response` (8,), or its first numbers where
            the others are 0.
        motion: The run.
        length: That lengths are counted in, m or rad.
        time_step: Longest plant step, s.
        uses: Effects with their parameters.
        is_held: Whether the command is held between samples.

    Returns:
        Position and speed (N, 2), in that length.

    Raises:
        BraceError: The run broke down (the message says when).
    """
    plugs = [stack_effects(uses)[point] for point in ("drive", "sensing")]
    log = np.zeros((len(motion.time), 2))
    law = np.append(law, np.zeros(NUMBERS - len(law)))
    broke_at = rollout_response(
        steps_per_sample(motion.time, time_step),
        sum(effect.on_command for effect, _ in uses),
        is_held,
        motion.time,
        motion.command / length,
        np.zeros((len(motion.time), 0)),
        law,
        *(p.laws for p in plugs),
        plugs[0].parameters,
        *(p.fresh_memory() for p in plugs),
        np.array([p.active for p in plugs]),
        motion.state / length,
        np.zeros(WORK),
        log,
    )
    if broke_at >= 0:
        raise BraceError(
            f"the simulated run broke down at {motion.time[broke_at]:.3f} s"
        )
    return log


def _pack(scenario: AxisScenario) -> FollowerNumbers:
    forward = scenario.feed_forward
    if scenario.command == "speed":
        rate = 1.0 / scenario.lag
        law = [rate, rate, 0.0, scenario.bias, forward]
    else:
        w, z = scenario.frequency, scenario.damping_ratio
        square, damping = w * w, 2.0 * z * w
        law = [square, damping, square, scenario.bias, forward * damping]
        if scenario.command == "motor":
            law[3:] = [square * scenario.offset, damping]
    is_of_error = scenario.integrates == "error"
    law += [scenario.integral, law[1] if is_of_error else law[4]]
    law.append(scenario.viscous)
    return FollowerNumbers(np.array(law), scenario.position_noise)
