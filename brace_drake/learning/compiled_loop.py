"""The brace between two decisions, by compiled laws alone."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.stack import modify_numbers, stack_effects
from brace_drake.laws import cubic
from brace_drake.laws.control.brace_control import GOOD
from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.rollout import LOST, DecisionPlan, run_decisions
from brace_drake.laws.plug_in import make_effects
from brace_drake.learning.episode import Episode
from brace_drake.learning.signals import Signals, calc_task_state, true_signals
from brace_drake.model.systems.brace_controller import (
    PROBLEMS,
    estimate_of_memory,
)
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_rings
from brace_drake.scenario.control_numbers import pack_control

# What a decision can come back with, in words.
BROKEN = {**PROBLEMS, LOST: "the rings or the torso are out of bounds"}


class CompiledLoop:
    """The closed loop of a scenario, equal to its diagram within 1e-8.

    Attributes:
        control: Kind, law and start of the controller.
        numbers, plug_ins, brace, held, reference, noise: Of the episode, see
            `laws.loop.rollout`; `brace` and `held` as they are by now.
        effects: Of the episode, their states as they are by now.
    """

    def __init__(
        self, scenario: BraceScenario, sample_time: float, motion_time: float
    ):
        self.control = pack_control(scenario.control, pack_rings(scenario))
        period = self.control.period
        self._n = len(scenario.stages)
        self._ticks = round(sample_time / period)
        self._steps = max(1, round(period / scenario.time_step))
        self._times = (period, motion_time)
        self._desired = np.empty(18 * self._n)

    def start(self, episode: Episode, stiffness: np.ndarray) -> None:
        """Sets everything to time 0 and performs the first tick."""
        n, control, period = self._n, self.control, self._times[0]
        numbers = episode.numbers.with_changes(control=control.law)
        self.numbers = numbers = modify_numbers(numbers, episode.uses)
        self.plug_ins = stack_effects(episode.uses, numbers)
        self.effects = make_effects(self.plug_ins, n)
        self.brace = make_brace(numbers, with_torso=True)
        self.reference = np.vstack([numbers.start, episode.way])
        self.noise = episode.draws * numbers.noise_sigma
        self.held = (
            control.pose.copy(),
            control.memory.copy(),
            control.virtual.copy(),
            np.zeros(18 * n),
        )
        self._stiffness = np.array(stiffness, dtype=float)
        plan = DecisionPlan(
            ticks=self._ticks,
            duration=self._times[1],
            reference=self.reference,
            stiffness=self._stiffness,
            noise=self.noise,
        )
        # Effects are handed to compiled code once, which takes its time.
        self._decisions = run_decisions(
            period / self._steps,
            self._steps,
            numbers,
            self.effects,
            self.brace,
            (control.kind, self.held),
            plan,
        )
        self._tick = 0
        self._go_on()

    def advance(self, stiffness: np.ndarray) -> None:
        """Goes on to the next decision with a stiffness (6n,) asked for.

        Raises:
            BraceError: The loop broke down; the message says how.
        """
        self._stiffness[:] = stiffness
        self._go_on()
        self._tick += self._ticks

    def _go_on(self) -> None:
        result = next(self._decisions)
        if result != GOOD:
            raise BraceError(BROKEN[result])

    @property
    def time(self) -> float:
        """Of the last tick, s."""
        return self._tick * self._times[0]

    @property
    def desired(self) -> np.ndarray:
        """X_d, X_d', X_d'' (18n,) now."""
        start, way = self.reference
        cubic.calc_cubic(self.time, self._times[1], start, way, self._desired)
        return self._desired

    @property
    def estimate(self) -> np.ndarray:
        """X, X', filtered force on the torso (18n,) as the controller knows."""
        pose, memory, _, _ = self.held
        return estimate_of_memory(pose, memory[0], self.numbers.start)

    @property
    def stiffness(self) -> np.ndarray:
        """K_d in use (6n,)."""
        return self.held[3][12 * self._n :]

    def truth(self) -> Signals:
        """What is, whatever the instruments read."""
        X = calc_task_state(self.brace.bodies, self.numbers.rest)
        return true_signals(self.desired, X, self.brace.f_T)
