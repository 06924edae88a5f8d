"""The twin of a user's diagram as fits and diagnoses see it."""

from __future__ import annotations

import copy
import threading
from collections import OrderedDict
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from brace_drake.devices.diagram.factory import MakeDiagram, call_factory
from brace_drake.devices.diagram.model import DiagramModel
from brace_drake.devices.diagram.rollout import (
    Commanded,
    read_log,
    simulate_diagram,
)
from brace_drake.devices.run_memory import RunMemory
from brace_drake.devices.subject import SubjectParameter
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.signal.ways import READING
from brace_drake.recording.columns import DIAGRAM, shown_unit, split_unit
from brace_drake.recording.recording import Run
from brace_drake.scenario.diagram import DiagramScenario

# Diagrams that are kept, each of other numbers.
_KEPT = 16
# Part of its limits that a fitted number is counted in.
_STEP = 0.05
# Samples before the first command moves of which a start is the median.
_START = 50


@dataclass(frozen=True)
class DiagramNumbers:
    """Numbers of a machine, and masses that are added to its bodies.

    Attributes:
        values: What its function is given.
        payloads: Mass, kg, and distance, m, by body.
    """

    values: Mapping[str, float]
    payloads: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def with_payload(
        self, body: str, mass: float, distance: float
    ) -> DiagramNumbers:
        """With a mass on a body, kg, at a distance from its frame, m."""
        load = {**self.payloads, body: (mass, distance)}
        return replace(self, payloads=load)

    def with_number_off(self, name: str, error: float) -> DiagramNumbers:
        """With a number that is more by an error."""
        values = {**self.values, name: self.values[name] + error}
        return replace(self, values=values)


class DiagramTwin(ReplayTwin):
    """Replays recorded commands on the user's diagram."""

    device = DIAGRAM
    has_loop = False

    def __init__(
        self,
        scenario: DiagramScenario,
        make: MakeDiagram,
        time_step: float | None = None,
    ):
        self.make = make
        self.channels = scenario.readings
        numbers = DiagramNumbers(dict(scenario.numbers))
        super().__init__(scenario, numbers, time_step)
        self.subject = _fitted(scenario)
        self._models = _Models(make, self.time_step)
        self._memory = RunMemory()

    def coarse(self) -> Self:
        """The same twin: its step is the user's."""
        return self

    def finer(self) -> Self:
        """The same twin with half the step."""
        return type(self)(self.scenario, self.make, self.time_step / 2.0)

    def scenario_of(self, subject: np.ndarray) -> DiagramScenario:
        """The scenario with a machine's fitted numbers, a copy."""
        out = copy.deepcopy(self.scenario)
        out.numbers |= self.with_subject(subject).values
        return out

    def with_subject(self, values: np.ndarray) -> DiagramNumbers:
        """The numbers of a machine, values in the order of `subject`."""
        named = zip(self.scenario.fitted, values, strict=True)
        own = {name: float(value) for name, value in named}
        return replace(self.numbers, values={**self.numbers.values, **own})

    def motion(self, run: Run) -> Commanded:
        """The run's commands, and where its joints begin."""
        scenario = self.scenario
        commands = run.stack(scenario.commands)
        moved = np.any(commands != commands[:1], axis=1)
        still = int(np.argmax(moved)) if moved.any() else len(moved)
        begins = slice(0, min(max(still, 1), _START))

        def start(columns: Mapping[str, str], joint: str) -> float:
            column = columns.get(joint)
            if column is None:
                return 0.0
            return float(np.median(run.channels[column][begins]))

        joints = dict.fromkeys([*scenario.start, *scenario.start_speed])
        period = float(np.median(np.diff(run.time_s)))
        return Commanded(
            period,
            commands,
            {
                joint: (
                    start(scenario.start, joint),
                    start(scenario.start_speed, joint),
                )
                for joint in joints
            },
        )

    def _replay(self, numbers, motion, subject, uses, generator):
        """Readings with noise of their own; nothing is fed back."""

        def run():
            with self._models.of(numbers.values) as model:
                return simulate_diagram(
                    model,
                    self.scenario,
                    motion,
                    self.time_step,
                    numbers.payloads,
                    uses,
                )

        # What happens to readings alone needs no run of its own.
        cards = self.scenario.placed_cards()
        ahead = [u for u in uses if cards[u[0].key].place != READING]
        log = self._memory.recall(_key(numbers, motion, ahead), run)
        readings = log
        if len(ahead) < len(uses):
            readings = read_log(self.scenario, motion, log, uses)
        return self._with_noise(readings, generator)

    def _with_noise(self, readings: np.ndarray, generator) -> np.ndarray:
        """Readings with white noise of their own; without a generator as they
        are.
        """
        if generator is None:
            return readings
        sigma = [self.scenario.noise.get(n, 0.0) for n in self.channels]
        noise = generator.standard_normal(readings.shape)
        return readings + noise * np.array(sigma)


def _key(numbers: DiagramNumbers, motion: Commanded, uses) -> Hashable:
    """What an exact replay depends on."""
    return (
        tuple(numbers.values.items()),
        tuple(sorted(numbers.payloads.items())),
        tuple(sorted(motion.start.items())),
        motion.commands.tobytes(),
        tuple((effect.key, own.tobytes()) for effect, own in uses),
    )


class _Models:
    """Diagrams by their numbers; each is used by one thread at a time."""

    def __init__(self, make: MakeDiagram, time_step: float):
        self._make, self._time_step = make, time_step
        self._idle: OrderedDict[tuple, list[DiagramModel]] = OrderedDict()
        self._lock = threading.Lock()

    @contextmanager
    def of(self, values: Mapping[str, float]) -> Iterator[DiagramModel]:
        """A diagram of some numbers that nobody else has; one that broke down
        does not come back.
        """
        key = tuple(values.items())
        with self._lock:
            idle = self._idle.get(key)
            model = idle.pop() if idle else None
        if model is None:
            diagram = call_factory(self._make, values)
            model = DiagramModel(diagram, self._time_step)
        yield model
        with self._lock:
            self._idle.setdefault(key, []).append(model)
            self._idle.move_to_end(key)
            while len(self._idle) > _KEPT:
                self._idle.popitem(last=False)


def _fitted(scenario: DiagramScenario) -> tuple[SubjectParameter, ...]:
    """Numbers that every recording is fitted anew."""
    found = []
    for name, (low, high) in scenario.fitted.items():
        value = scenario.numbers[name]
        unit = shown_unit(split_unit(name)[1]) or "1"
        step = _STEP * (high - low)
        found.append(SubjectParameter(name, unit, value, low, high, step))
    return tuple(found)
