"""What a campaign holds in memory: runs of named channels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from brace_drake.recording.columns import (
    Channel,
    device_channels,
    port_channels,
)
from brace_drake.recording.findings import Problem
from brace_drake.recording.ports import Ports


@dataclass(frozen=True)
class Run:
    """One recording: equally long channels, SI units in their names."""

    file: str
    contact: bool
    motion: str
    repeat_of: str | None
    split: str  # "fit" | "validation"
    channels: dict[str, np.ndarray]
    # How long the first reference had been held, s; 0: switched on with it.
    settled_s: float = 0.0

    @property
    def name(self) -> str:
        """File name without its ending."""
        return Path(self.file).stem

    @property
    def time_s(self) -> np.ndarray:
        """Sample times, shape (N,), s."""
        return self.channels["time_s"]

    def stack(self, columns: list[str] | tuple[str, ...]) -> np.ndarray:
        """The named columns side by side, shape (N, len(columns)).

        0 where a channel was not recorded, see `has`.
        """
        nothing = np.zeros(len(self.time_s))
        return np.column_stack([self.channels.get(c, nothing) for c in columns])

    def has(self, columns: Sequence[str]) -> np.ndarray:
        """Which of the columns were recorded, bool (len(columns),)."""
        return np.array([c in self.channels for c in columns])


@dataclass(frozen=True)
class Campaign:
    """A campaign folder: a device, and runs of it."""

    path: Path
    device: str
    rate_hz: float
    subject: str
    runs: tuple[Run, ...]
    nominal: dict[str, float] = field(default_factory=dict)
    control: dict[str, float] = field(default_factory=dict)
    stages: tuple[int, ...] = ()  # of a brace; empty: all
    warnings: tuple[Problem, ...] = ()
    ports: Ports | None = None  # of a diagram
    recorded: str = ""  # when, as the manifest has it

    @property
    def name(self) -> str:
        """The folder's name."""
        return self.path.name

    @property
    def known_channels(self) -> dict[str, Channel]:
        """Channels that its recordings may have, by name."""
        if self.ports is not None:
            return port_channels(self.ports.columns, self.ports.commands)
        return device_channels(self.device, self.stages)

    def split(self, split: str) -> tuple[Run, ...]:
        """Runs of one split, "fit" or "validation"."""
        return tuple(run for run in self.runs if run.split == split)
