"""What the twins of all devices share: values in, recorded channels out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.subject import SubjectParameter
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use, modify_numbers
from brace_drake.recording.recording import Run
from brace_drake.scenario.effects import effects_of, scenario_uses

# Faster than this a brace and a torso do not move; noise alone is above.
HIGHEST_HZ = 50.0


class Request(NamedTuple):
    """A replay that is asked of a twin.

    Attributes:
        motion: From `ReplayTwin.motion`.
        subject: Values of the subject's parameters.
        uses: Effects with their parameters, beside the carried ones.
        seed: Of the reading noise; None: exact readings.
    """

    motion: Any
    subject: np.ndarray
    uses: Sequence[Use] = ()
    seed: tuple[int, ...] | None = None


class ReplayTwin(ABC):
    """Replays recorded references on a compiled device.

    Attributes:
        channels: Names of the columns of what `simulate` returns.
        has_loop: Whether readings, with their noise, feed back to the motion.
        finds_loop: Whether its numbers come from the runs themselves, beside
            what may hide them.
        num_lanes: How many replays go side by side in `simulate_each`.
        device: That the twin is of.
        numbers: What the compiled laws take.
        subject: Parameters to be estimated for every subject.
        carried: Effects of the scenario, always on.
    """

    channels: ClassVar[tuple[str, ...]]
    has_loop: ClassVar[bool]
    finds_loop: ClassVar[bool] = False
    num_lanes: ClassVar[int] = 1
    device: str
    subject: tuple[SubjectParameter, ...]

    def __init__(self, scenario, numbers, time_step: float | None = None):
        """Takes a scenario, its packed numbers and a plant step, s.

        Without a step, that of the scenario.
        """
        self.scenario = scenario
        self.numbers = numbers
        self.time_step = time_step or scenario.time_step
        self.carried = scenario_uses(scenario)

    def effects(self) -> dict[str, Effect]:
        """Effects that the device can have, by key."""
        return effects_of(self.scenario)

    @abstractmethod
    def coarse(self) -> Self:
        """The same twin with the longest plant step that stays accurate."""

    def finer(self) -> Self:
        """The same twin with half the plant step."""
        return type(self)(self.scenario, self.time_step / 2.0)

    @abstractmethod
    def scenario_of(self, subject: np.ndarray) -> Any:
        """The scenario with a subject's numbers, a copy."""

    @abstractmethod
    def with_subject(self, values: np.ndarray) -> Any:
        """The numbers of a subject, values in the order of `subject`."""

    @abstractmethod
    def motion(self, run: Run) -> Any:
        """What a recorded run is asked to do."""

    def measured(self, run: Run) -> np.ndarray:
        """The run's recorded channels, shape (N, C)."""
        return run.stack(self.channels)

    def trust(self, motion) -> np.ndarray | float:
        """How far each sample counts (N, 1), 0 to 1, as what is imposed may be
        known badly: what is measured and what is simulated have it in them.
        """
        return 1.0

    def written(self, run: Run) -> np.ndarray:
        """What is measured, without `trust` in it (N, C)."""
        return self.measured(run)

    def recorded(self, run: Run) -> np.ndarray:
        """Which channels a run has, bool (C,)."""
        return run.has(self.channels)

    @property
    def reading_steps(self) -> np.ndarray:
        """To what instruments round, where their noise has that in it (C,); 0:
        not at all, or not known.
        """
        return np.zeros(len(self.channels))

    def active(self, run: Run) -> np.ndarray:
        """Which channels carry information in a run, bool (C,)."""
        return np.ones(len(self.channels), dtype=bool)

    def simulate(
        self,
        motion,
        subject: np.ndarray,
        uses: Sequence[Use] = (),
        generator: np.random.Generator | None = None,
    ) -> np.ndarray:
        """Replay of a run, shape (N, C); it may not be writable.

        Args:
            motion: From `motion`.
            subject: Values of the subject's parameters.
            uses: Effects with their parameters, beside the carried ones.
            generator: Draws the reading noise; None: exact readings.

        Raises:
            BraceError: The simulated run broke down.
        """
        numbers, uses = self._machine(subject, uses)
        return self._replay(numbers, motion, subject, uses, generator)

    def _machine(
        self, subject: np.ndarray, uses: Sequence[Use]
    ) -> tuple[Any, tuple[Use, ...]]:
        """Numbers of a subject as all effects have changed them, and these."""
        uses = (*self.carried, *uses)
        return modify_numbers(self.with_subject(subject), uses), uses

    def simulate_each(
        self, requests: Sequence[Request]
    ) -> list[np.ndarray | None]:
        """`simulate` of several requests, each what it is alone; None where
        the run broke down.
        """
        logs: list[np.ndarray | None] = []
        for motion, subject, uses, seed in requests:
            generator = None if seed is None else np.random.default_rng(seed)
            try:
                logs.append(self.simulate(motion, subject, uses, generator))
            except BraceError:
                logs.append(None)
        return logs

    @abstractmethod
    def _replay(
        self,
        numbers,
        motion,
        subject: np.ndarray,
        uses: Sequence[Use],
        generator: np.random.Generator | None,
    ) -> np.ndarray:
        """`simulate` of the subject's numbers, with all effects."""
