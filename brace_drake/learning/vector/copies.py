"""Several braces between two decisions, four in each pass of compiled code."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.laws.control.brace_control import GOOD, make_controller
from brace_drake.laws.hooks import Effects
from brace_drake.laws.lanes.arrays import in_one_piece, put_copy, stack_copies
from brace_drake.laws.lanes.kinds import COUNT
from brace_drake.laws.loop.decide_copies import (
    EpisodeCopy,
    num_reported,
    run_decisions_of_copies,
)
from brace_drake.laws.plug_in import make_effects_of
from brace_drake.learning.compiled_loop import BROKEN, CompiledLoop
from brace_drake.learning.signals import (
    Signals,
    signals_of_estimate,
    true_signals,
)
from brace_drake.scenario.brace import BraceScenario


class CompiledCopies:
    """Closed loops of a scenario, each what `CompiledLoop` is, to the last bit.

    Attributes:
        reports: After each decision, of every loop, see
            `laws.loop.decide_copies.report_copies` (count, 57n).
    """

    def __init__(
        self,
        scenario: BraceScenario,
        sample_time: float,
        motion_time: float,
        count: int,
    ):
        n = len(scenario.stages)
        self._m, self._count = 6 * n, count
        fours = -(-count // COUNT)
        self._out = np.zeros((fours, num_reported(n), COUNT))
        self._fours = [
            _Four(scenario, sample_time, motion_time, out) for out in self._out
        ]

    def put(self, index: int, loop: CompiledLoop) -> None:
        """A loop that has been started goes on here."""
        self._fours[index // COUNT].put(index % COUNT, loop)

    def advance(
        self, stiffness: np.ndarray, active: Sequence[int]
    ) -> dict[int, str]:
        """Goes on to the next decision of loops, the others stay as they are.

        Args:
            stiffness: Asked for, of all loops (count, 6n), N/m.
            active: Which ones go on.

        Returns:
            Those that broke down, and how.
        """
        broken = {}
        for at, four in enumerate(self._fours):
            first = COUNT * at
            places = [i - first for i in active if 0 <= i - first < COUNT]
            if places:
                found = four.advance(stiffness[first : first + COUNT], places)
                for place, result in found.items():
                    broken[first + place] = BROKEN[result]
        size = self._out.shape[1]
        rows = self._out.transpose(0, 2, 1).reshape(-1, size)
        self.reports = rows[: self._count]
        return broken

    def truth(self) -> Signals:
        """What is, whatever the instruments read, of all loops."""
        m, rows = self._m, self.reports
        X = rows[:, 3 * m : 5 * m].reshape(-1, 2, m)
        pads = rows[:, 5 * m : 5 * m + m // 2]
        return true_signals(rows[:, : 3 * m], X, pads)

    def known(self) -> Signals:
        """What the controllers know, of all loops."""
        a = 5 * self._m + self._m // 2
        estimate = self.reports[:, a : a + 3 * self._m]
        return signals_of_estimate(estimate, self.reports[:, : 3 * self._m])

    def stiffness(self) -> np.ndarray:
        """K_d in use, of all loops (count, 6n)."""
        return self.reports[:, -self._m :]


class _Four:
    """COUNT loops side by side."""

    def __init__(self, scenario: BraceScenario, sample_time, motion_time, out):
        period = 1.0 / scenario.control.rate
        self._steps = max(1, round(period / scenario.time_step))
        self._times = round(sample_time / period), period, motion_time
        self._n, self._out = len(scenario.stages), out
        self._decisions = None

    def put(self, place: int, loop: CompiledLoop) -> None:
        """A loop that has been started goes on in a place."""
        copy = _copy_of(loop, place, self._n)
        if self._decisions is None:
            self._start(loop, copy)
        put_copy(self._parts, copy, place)
        if len(self._noise):
            self._noise[place, : len(loop.noise)] = loop.noise
        for own, whole in self._effect_parts():
            whole_of_loop = getattr(loop.effects, own)
            at = self._where[own]
            whole[at[place]] = whole_of_loop[self._where_alone[own][0]]

    def advance(self, stiffness, places: Sequence[int]) -> dict[int, int]:
        """Continues some places; those that broke down, and how."""
        asked = self._parts[3].stiffness
        asked[:, : len(stiffness)] = stiffness.T
        broken = {}
        for together in self._at_the_same_time(places):
            before = self._take()
            if self._go_on(together) == GOOD:
                continue
            self._put_back(before, range(COUNT))
            for place in together:
                before = self._take()
                result = self._go_on([place])
                if result != GOOD:
                    self._put_back(before, [place])
                    broken[place] = result
        return broken

    def _at_the_same_time(self, places):
        """Effects are told the time, so those at another one go by
        themselves.
        """
        if not self._effects.active.any():
            return [places]
        ticks = self._parts[3].tick[0]
        return [
            [p for p in places if ticks[p] == tick]
            for tick in dict.fromkeys(ticks[p] for p in places)
        ]

    def _go_on(self, places: Sequence[int]) -> int:
        """One pass for some places; in the others goes a copy of the first."""
        others = [p for p in range(COUNT) if p not in places]
        if not others:
            return next(self._decisions)
        before = self._take()
        for whole, at in self._all():
            for p in others:
                whole[at[p]] = whole[at[places[0]]]
        result = next(self._decisions)
        self._put_back(before, others)
        return result

    def _start(self, loop: CompiledLoop, copy) -> None:
        """Makes room, with the first loop in all places."""
        self._parts, whole = in_one_piece(stack_copies([copy] * COUNT))
        numbers, brace, controller, episode = self._parts
        effects = self._effects = make_effects_of(
            [loop.plug_ins] * COUNT, self._n, COUNT
        )
        self._where, self._where_alone = (
            _places_of(effects),
            _places_of(loop.effects),
        )
        flat = whole.reshape(-1)
        self._wholes = [
            (flat, [np.s_[p::COUNT] for p in range(COUNT)]),
            (self._out.reshape(-1), [np.s_[p::COUNT] for p in range(COUNT)]),
        ]
        self._noise = np.zeros(
            (COUNT if len(loop.noise) else 0, *loop.noise.shape)
        )
        many, period, duration = self._times
        self._decisions = run_decisions_of_copies(
            period / self._steps, self._steps, numbers, effects, brace,
            controller, episode, self._noise, (many, period, duration),
            self._out,
        )  # fmt: skip

    def _effect_parts(self):
        if not self._effects.active.any():
            return []
        return [
            (n, getattr(self._effects, n)) for n in ("parameters", "memory")
        ]

    def _all(self):
        """Vectors of all places, and where in them each place is."""
        effects = [(whole, self._where[n]) for n, whole in self._effect_parts()]
        return [*self._wholes, *effects]

    def _take(self) -> list[np.ndarray]:
        return [whole.copy() for whole, _ in self._all()]

    def _put_back(self, before: list[np.ndarray], places) -> None:
        for (whole, at), old in zip(self._all(), before, strict=True):
            for p in places:
                whole[at[p]] = old[at[p]]


def _copy_of(loop: CompiledLoop, place: int, n: int) -> tuple:
    """What a loop that has been started has, as one copy."""
    numbers = loop.numbers
    kind = loop.control.kind
    return (
        numbers,
        loop.brace,
        make_controller(kind, numbers.control, loop.held),
        EpisodeCopy(
            tick=np.zeros(1),
            place=np.full(1, float(place)),
            reference=loop.reference,
            stiffness=np.zeros(6 * n),
            noise=np.zeros(loop.noise.shape[1] if len(loop.noise) else 0),
            desired=np.zeros(18 * n),
        ),
    )


def _places_of(effects: Effects) -> dict[str, list[np.ndarray]]:
    """Where each copy's parameters and states are, in the same order."""
    places, copies = effects.places, effects.places.shape[2]
    found = {}
    for name, rows in (("parameters", [0]), ("memory", range(1, len(places)))):
        of_copies = []
        for copy in range(copies):
            at = []
            for row in rows:
                for e, at_once in enumerate(effects.together):
                    own = 0 if at_once else copy
                    first, step = (copy, copies) if at_once else (0, 1)
                    for a, b in places[row, e, own]:
                        at.append(np.arange(a + first, b, step))
            of_copies.append(np.concatenate(at))
        found[name] = of_copies
    return found
