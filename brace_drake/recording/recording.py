"""What a campaign holds in memory: runs of named channels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from brace_drake.core.frames import make_frame
from brace_drake.recording.columns import (
    Channel,
    device_channels,
    port_channels,
)
from brace_drake.recording.findings import Problem
from brace_drake.recording.ports import Ports


@dataclass(frozen=True, repr=False)
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

    def __repr__(self) -> str:
        if "time_s" not in self.channels or not len(self.time_s):
            return f"<Run {self.name}: {self.split}, without samples>"
        seconds = float(self.time_s[-1] - self.time_s[0])
        return (
            f"<Run {self.name}: {self.split}, {len(self.channels)} channels,"
            f" {seconds:.4g} s>"
        )

    @property
    def name(self) -> str:
        """File name without its ending."""
        return Path(self.file).stem

    @property
    def time_s(self) -> np.ndarray:
        """Sample times, shape (N,), s; as loaded from 0 on."""
        return self.channels["time_s"]

    def stack(self, columns: list[str] | tuple[str, ...]) -> np.ndarray:
        """The named columns side by side, shape (N, len(columns)).

        0 where a channel was not recorded, see `has`.
        """
        nothing = np.zeros(len(self.time_s))
        return np.column_stack([self.channels.get(c, nothing) for c in columns])

    def to_pandas(self) -> Any:
        """Its channels as a DataFrame, a column each.

        Raises:
            ExtraError: pandas is not installed.
        """
        return make_frame(self.channels)

    def has(self, columns: Sequence[str]) -> np.ndarray:
        """Which of the columns were recorded, bool (len(columns),)."""
        return np.array([c in self.channels for c in columns])


@dataclass(frozen=True)
class ScenarioFile:
    """The scenario that a campaign names.

    Attributes:
        name: Path as campaign.yaml has it, relative to the folder.
        data: Its content.
    """

    name: str
    data: bytes = field(repr=False, default=b"")


@dataclass(frozen=True, repr=False)
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
    scenario: ScenarioFile | None = None
    recorded: str = ""  # when, a date as the manifest has it
    # What a device has told of itself while it was recorded.
    recorder: dict[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        splits = [f"{len(self.split(s))} {s}" for s in ("fit", "validation")]
        return (
            f"<Campaign {self.name}: {self.device}, {self.rate_hz:g} Hz,"
            f" {' and '.join(splits)} runs>"
        )

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
