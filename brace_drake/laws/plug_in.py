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
    others have none.
    """
    size = (len(STAGE_POINTS), MAX_EFFECTS, count)
    laws = np.zeros(size, dtype=np.int64)
    places = np.zeros((1 + size[0], *size[1:], num_stages, 2), dtype=np.int64)
    parameters, memory = _Behind(), _Behind()
    for c, plug_ins in enumerate(copies):
        plugs = [plug_ins.get(point) or idle(point) for point in STAGE_POINTS]
        of_effects = next((p for p in plugs if not p.is_idle), plugs[0])
        for e in range(MAX_EFFECTS):
            own = of_effects.parameters[e]
            places[0, e, c] = parameters.add(own, num_stages)
            for at, plug in enumerate(plugs):
                places[1 + at, e, c] = memory.add(plug.initial[e], num_stages)
                if plug.active[e]:
                    laws[at, e, c] = address_of(plug.laws[e], plug.point)
    return Effects(
        laws,
        parameters.whole(),
        memory.whole(),
        places,
        (laws != 0).any(axis=-1),
        np.zeros((5, 12)),
    )


class _Behind:
    """Vectors of stages, one behind the other."""

    def __init__(self):
        self._rows, self._size = [], 0

    def add(self, values: np.ndarray, num_stages: int) -> np.ndarray:
        """Where a row for each stage begins and ends (n, 2)."""
        rows = np.broadcast_to(values, (num_stages, values.shape[-1]))
        self._rows.append(rows.ravel())
        at = self._size + values.shape[-1] * np.arange(num_stages + 1)
        self._size = int(at[-1])
        return np.stack([at[:-1], at[1:]], axis=-1)

    def whole(self) -> np.ndarray:
        return np.concatenate(self._rows)
