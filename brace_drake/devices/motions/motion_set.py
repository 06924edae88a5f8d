"""Motions that a device may be asked for, and what they may not pass."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from brace_drake.recording.recording import Run


class PlannedMotion(Protocol):
    """A motion to run.

    Attributes:
        name: Identifier.
        meaning: What moves and how, in a few words.
        contact: As in recordings of its kind.
        run: The motion as a run that has not been recorded yet.
        columns: Channels of the run that are imposed.
    """

    @property
    def name(self) -> str: ...

    @property
    def meaning(self) -> str: ...

    @property
    def contact(self) -> bool: ...

    @property
    def run(self) -> Run: ...

    @property
    def columns(self) -> tuple[str, ...]: ...


@dataclass(frozen=True)
class MotionSet:
    """Motions for a device.

    Attributes:
        rate: Of their samples, Hz.
        motions: To choose from.
        exceeded: From (twin, motion, subject values, the twin's recording of
            it (N, C)) to which limit it passes, in words; None where it keeps
            them all.
    """

    rate: float
    motions: Sequence[PlannedMotion]
    exceeded: Callable
