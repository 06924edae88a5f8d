"""The effects that sit at one plug point, as systems and rollouts take them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brace_drake.laws.hooks import MAX_EFFECTS, NO_LAW


@dataclass(frozen=True)
class PlugIn:
    """Laws at one plug point, always MAX_EFFECTS of them.

    Attributes:
        point: Name of the plug point.
        laws: Compiled laws; idle places hold a law that does nothing.
        parameters: Parameter vector of each effect.
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
