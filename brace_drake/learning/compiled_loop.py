"""The brace between two decisions, by compiled laws alone."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.effects.stack import stack_laws
from brace_drake.laws import cubic
from brace_drake.laws.control import brace_control
from brace_drake.laws.hooks import PLUG_POINTS
from brace_drake.laws.loop import kernels
from brace_drake.laws.loop.brace_loop import (
    LOST,
    advance_brace_loop,
    advance_hooked_loop,
    read_task_state,
)
from brace_drake.laws.stages import place_rings
from brace_drake.learning.episode import Episode
from brace_drake.learning.signals import Signals
from brace_drake.model.systems.brace_controller import (
    PROBLEMS,
    estimate_of_memory,
)
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace, pack_rings
from brace_drake.scenario.control_numbers import pack_control


class CompiledLoop:
    """The closed loop of a scenario, equal to its diagram within 1e-8."""

    def __init__(
        self, scenario: BraceScenario, sample_time: float, motion_time: float
    ):
        self._numbers = numbers = pack_brace(scenario)
        self._control = pack_control(scenario.control, pack_rings(scenario))
        period = self._control.period
        self._n = n = numbers.num_stages
        self._ticks = round(sample_time / period)
        self._steps = max(1, round(period / scenario.time_step))
        self._times = (period, motion_time)
        self._ring = numbers.ring
        self._state_size = 13 * (n + 1)
        law_at = self._state_size + 6 * n
        self._inputs = np.zeros(law_at + kernels.num_law(n))
        self._law = self._inputs[law_at:]
        self._out = np.zeros(kernels.num_forces(n, with_work=True))
        self._X = np.empty((2, 6 * n))
        self._desired = np.empty(18 * n)
        self._rest = np.ascontiguousarray(numbers.geometry.rest)

    def start(self, episode: Episode, stiffness: np.ndarray) -> None:
        """Sets everything to time 0 and performs the first tick."""
        n, control = self._n, self._control
        self._inputs[:] = 0.0
        poses = np.empty((n, 7))
        place_rings(self._numbers.start, self._rest, poses)
        self._inputs[0 : 7 * n] = poses.ravel()
        self._inputs[7 * n] = 1.0
        self._inputs[7 * n + 4 : 7 * n + 7] = self._numbers.torso_rest
        self._law[:] = episode.force_law
        torso = np.append(episode.torso, 0.0)
        self._mass = np.vstack([*[self._ring] * n, torso])
        self._reference = np.vstack([self._numbers.start, episode.way])
        plugs = stack_laws(episode.uses)
        self._advance, self._hooks = advance_brace_loop, ()
        if episode.uses:
            self._advance = advance_hooked_loop
            self._hooks = (
                *(plugs[p].laws for p in PLUG_POINTS),
                plugs[PLUG_POINTS[0]].parameters,
                *(plugs[p].fresh_memory() for p in PLUG_POINTS),
                np.array([plugs[p].active for p in PLUG_POINTS]),
            )
        self._noise = episode.draws * self._numbers.noise_sigma
        self._memory = control.memory.copy()
        self._held = (
            control.pose.copy(),
            control.virtual.copy(),
            np.zeros(18 * n),
            np.zeros(9 * n + 3),
        )
        self._tick = 0
        self._call(stiffness, 0)

    def advance(self, stiffness: np.ndarray) -> None:
        """Goes on to the next decision with a stiffness (6n,) asked for.

        Raises:
            BraceError: The loop broke down; the message says how.
        """
        self._call(stiffness, self._ticks)
        self._tick += self._ticks

    def _call(self, stiffness: np.ndarray, ticks: int) -> None:
        result = self._advance(
            (self._control.kind, self._tick, ticks, self._steps),
            self._times,
            self._reference,
            stiffness,
            self._inputs,
            self._mass,
            self._control.law,
            self._held,
            self._memory,
            self._numbers.resolution,
            self._noise,
            self._out,
            *self._hooks,
        )
        if result == LOST:
            raise BraceError("the rings or the torso are out of bounds")
        if result != brace_control.GOOD:
            raise BraceError(PROBLEMS[result])

    @property
    def time(self) -> float:
        """Of the last tick, s."""
        return self._tick * self._times[0]

    @property
    def desired(self) -> np.ndarray:
        """X_d, X_d', X_d'' (18n,) now."""
        start, way = self._reference
        cubic.calc_cubic(self.time, self._times[1], start, way, self._desired)
        return self._desired

    @property
    def estimate(self) -> np.ndarray:
        """X, X', filtered force on the torso (18n,) as the controller knows."""
        pose, start = self._held[0], self._numbers.start
        return estimate_of_memory(pose, self._memory[0], start)

    @property
    def stiffness(self) -> np.ndarray:
        """K_d in use (6n,)."""
        return self._held[2][12 * self._n :]

    def truth(self) -> Signals:
        """What is, whatever the instruments read."""
        n = self._n
        read_task_state(self._inputs, self._rest, self._X)
        desired, force = self.desired, np.zeros((n, 6))
        pads = self._out[12 * n + 6 : 15 * n + 6]
        force[:, 0:3] = -pads.reshape(n, 3)
        return Signals(
            desired[0 : 6 * n].copy(),
            desired[6 * n : 12 * n].copy(),
            self._X[0].copy(),
            self._X[1].copy(),
            force.ravel(),
        )
