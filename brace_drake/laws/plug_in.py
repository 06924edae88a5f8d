"""The effects that sit at one plug point, as systems and rollouts take them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.laws.hooks import (
    MAX_EFFECTS,
    NO_LAW,
    STAGE_POINTS,
    Effects,
    address_of,
    serves_lanes,
)


@dataclass(frozen=True)
class PlugIn:
    """Laws at one plug point, always MAX_EFFECTS of them.

    Attributes:
        point: Name of the plug point.
        laws: Compiled laws; idle places hold a law that does nothing.
        parameters: Parameter vector of each effect, one for all stages (m,)
            or one for each (n, m).
        initial: Initial states of each effect at this point.
    """

    point: str
    laws: tuple[Callable, ...]
    parameters: tuple[np.ndarray, ...]
    initial: tuple[np.ndarray, ...]

    @property
    def is_idle(self) -> bool:
        """Whether no effect sits here."""
        return not any(self.active)

    @property
    def active(self) -> tuple[bool, ...]:
        """Whether each place holds an effect's law."""
        return tuple(law is not NO_LAW[self.point] for law in self.laws)

    def fresh_memory(self) -> tuple[np.ndarray, ...]:
        """Copies of the initial states, to be advanced by a rollout."""
        return tuple(x.copy() for x in self.initial)


def idle(point: str) -> PlugIn:
    """A plug point without any effect."""
    empty = tuple(np.zeros(1) for _ in range(MAX_EFFECTS))
    laws = (NO_LAW[point],) * MAX_EFFECTS
    return PlugIn(point, laws, empty, empty)


def make_effects(plug_ins: Mapping[str, PlugIn], num_stages: int) -> Effects:
    """Effects of all plug points, of each stage with states of its own.

    Args:
        plug_ins: By plug point, of the same effects; idle where absent.
        num_stages: n.
    """
    return make_effects_of([plug_ins], num_stages, 1)


def make_effects_of(
    copies: Sequence[Mapping[str, PlugIn]], num_stages: int, count: int
) -> Effects:
    """Effects of several copies; where there are fewer than `count`, the
    others have none, or those of the last, see `Effects.together`.
    """
    size = (len(STAGE_POINTS), MAX_EFFECTS, count)
    laws = np.zeros(size, dtype=np.int64)
    places = np.zeros((1 + size[0], *size[1:], num_stages, 2), dtype=np.int64)
    parameters, memory = _Behind(num_stages), _Behind(num_stages)
    plugs = [
        [plug_ins.get(point) or idle(point) for point in STAGE_POINTS]
        for plug_ins in copies
    ]
    together = np.array(
        [count > 1 and _is_together(plugs, e) for e in range(MAX_EFFECTS)]
    )
    for e, at_once in enumerate(together):
        # Each copy, or all of them as the first.
        filled = [*plugs, *[plugs[-1]] * (count - len(plugs))]
        for c, some in enumerate([filled] if at_once else [[p] for p in plugs]):
            places[0, e, c] = parameters.add(
                [_parameters_of(of_copy, e) for of_copy in some]
            )
            for at, plug in enumerate(some[0]):
                places[1 + at, e, c] = memory.add(
                    [of_copy[at].initial[e] for of_copy in some]
                )
                if plug.active[e]:
                    laws[at, e, c] = address_of(
                        plug.laws[e], plug.point, bool(at_once)
                    )
    return Effects(
        laws,
        parameters.whole(),
        memory.whole(),
        places,
        (laws != 0).any(axis=-1),
        together,
        np.zeros((5, 15)),
    )


def _is_together(copies: Sequence[Sequence[PlugIn]], e: int) -> bool:
    """Whether all copies have the same laws of an effect, made for lanes."""
    own = [plug.laws[e] for plug in copies[0]]
    return all(
        [plug.laws[e] for plug in plugs] == own for plugs in copies
    ) and all(
        not plug.active[e] or serves_lanes(plug.laws[e], plug.point)
        for plug in copies[0]
    )


def _parameters_of(plugs: Sequence[PlugIn], e: int) -> np.ndarray:
    # Numbers of what has no law here, as of the frame, act elsewhere.
    return next((p.parameters[e] for p in plugs if p.active[e]), np.zeros(1))


class _Behind:
    """Vectors of stages, one behind the other."""

    def __init__(self, num_stages: int):
        self._num_stages = num_stages
        self._rows, self._size = [], 0

    def add(self, copies: Sequence[np.ndarray]) -> np.ndarray:
        """Where a row for each stage begins and ends (n, 2); in a row the
        copies of each number lie behind each other.
        """
        n = self._num_stages
        rows = [np.broadcast_to(v, (n, v.shape[-1])).ravel() for v in copies]
        row = rows[0] if len(rows) == 1 else np.stack(rows, axis=-1).ravel()
        self._rows.append(row)
        at = self._size + len(row) // n * np.arange(n + 1)
        self._size = int(at[-1])
        return np.stack([at[:-1], at[1:]], axis=-1)

    def whole(self) -> np.ndarray:
        return np.concatenate(self._rows)
