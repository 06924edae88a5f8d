"""The effects that sit at one plug point, as systems and rollouts take them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from brace_drake.laws.hooks import MAX_EFFECTS, NO_LAW, STAGE_POINTS, Effects


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
    plugs = [plug_ins.get(point) or idle(point) for point in STAGE_POINTS]
    of_effects = next((p for p in plugs if not p.is_idle), plugs[0])
    return Effects(
        laws=tuple(plug.laws for plug in plugs),
        parameters=_of_stages(of_effects.parameters, num_stages),
        memory=tuple(_of_stages(plug.initial, num_stages) for plug in plugs),
        active=np.array([plug.active for plug in plugs]),
    )


def _of_stages(
    values: tuple[np.ndarray, ...], num_stages: int
) -> tuple[np.ndarray, ...]:
    """A row for each stage, copied."""
    return tuple(
        np.array(np.broadcast_to(v, (num_stages, v.shape[-1])), order="C")
        for v in values
    )
