"""A recording fault that was found: where, how large, how sure."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from brace_drake.recording.findings import Problem
from brace_drake.recording_faults.card import RecordingFault

# More is not claimed of anything that a statistic tells.
MOST_PROBABLE = 0.99


@dataclass(frozen=True)
class Finding:
    """One fault in one or more runs.

    Attributes:
        fault: Its card.
        runs: Files it is in.
        of_all: Whether these are all runs that could have it.
        channels: That are concerned; none: whole runs.
        parameters: Of the card, by name.
        probability: That this is the fault.
        detail: What was seen, a clause with its numbers.
        severity: "error" where the campaign cannot be diagnosed as it is,
            "warning" where it can.
        row: First data row from 1 that shows it, where one does.
        is_decisive: Whether a warning has no name, but no doubt either: the
            verdict on the machine does not count.
        before, after: Mean square of what contradicts it, in noise floors,
            and with the fault undone; None where nothing was replayed.
    """

    fault: RecordingFault
    runs: tuple[str, ...]
    channels: tuple[str, ...] = ()
    parameters: Mapping[str, float] = field(default_factory=dict)
    probability: float = MOST_PROBABLE
    detail: str = ""
    severity: str = "error"
    row: int | None = None
    of_all: bool = False
    is_decisive: bool = False
    before: float | None = None
    after: float | None = None

    @property
    def is_certain(self) -> bool:
        """Whether no verdict on the machine counts beside it."""
        return self.is_decisive or self.severity == "error"

    @property
    def place(self) -> str:
        """The runs in words: "all runs", or their files."""
        if self.of_all and len(self.runs) > 1:
            return "all runs"
        return ", ".join(self.runs)

    def what(self) -> str:
        """Channels and what befell them: "leg2_length_m stuck at one value"."""
        name = channel_words(self.channels)
        return f"{name} {self.fault.title}".strip()

    def sentence(self) -> str:
        """As the verdict says it."""
        p = f"p {self.probability:.2f}".replace("0.", ".", 1)
        seen = f"; {self.detail}" if self.detail else ""
        whose = (
            "The recording, not the machine"
            if self.is_certain
            else "Perhaps the recording"
        )
        return f"{whose}: {self.what()} in {self.place} ({p}){seen}."

    def row_of_verdict(self) -> dict:
        """As `verdict.recording` lists it."""
        return {
            "fault": self.fault.name,
            "run": "all" if self.of_all else ", ".join(self.runs),
            "channel": ", ".join(self.channels) or None,
            "parameters": dict(self.parameters),
            "probability": self.probability,
            "sentence": self.sentence(),
            "remedy": self.fault.remedy,
        }

    def problems(self) -> list[Problem]:
        """Lines of a check, one for each run."""
        seen = f": {self.detail}" if self.detail else ""
        message = f"{self.what()}{seen}; {self.fault.remedy}"
        column = self.channels[0] if len(self.channels) == 1 else None
        first = self.runs[:1] if self.of_all else self.runs
        row = self.row if len(self.runs) == 1 else None
        if self.of_all and len(self.runs) > 1:
            message = f"in all runs: {message}"
        return [
            Problem(self.severity, run, message, row, column) for run in first
        ]


def recording_verdict(findings: Sequence[Finding]) -> dict:
    """Keys of a diagnosis' verdict that recording faults decide; `recording`
    alone where none is certain.
    """
    rows = [f.row_of_verdict() for f in findings]
    certain = [f for f in findings if f.is_certain]
    if not certain:
        return {"recording": rows}
    return {
        "recording": rows,
        "gap": True,
        "effects": [],
        "supported": [],
        "blocks": [],
        "unexplained": {
            "share": 0.0,
            "block": None,
            "description": "",
            "law": None,
        },
        "outside_library": False,
        "ambiguous_with": [],
        "confirmed": None,
        "contradicted": None,
        "probability": max(f.probability for f in certain),
        "sentence": " ".join(f.sentence() for f in certain[:3]),
    }


_LEG = re.compile(r"leg(\d+)_(length|force_command)_")


def channel_words(channels: Sequence[str]) -> str:
    """Names of channels as a reader has them: "leg 2 and leg 3 lengths"."""
    parts = [_LEG.match(n) for n in channels]
    if channels and all(parts):
        legs = list(dict.fromkeys(f"leg {m[1]}" for m in parts if m))
        kinds = {m[2].split("_")[-1] for m in parts if m}
        kind = kinds.pop() if len(kinds) == 1 else "length and command"
        if len(legs) > 3:
            return f"{kind}s of {len(legs)} legs"
        return f"{' and '.join(legs)} {kind}{'s' if len(legs) > 1 else ''}"
    if len(channels) <= 3:
        return " and ".join(channels)
    return f"{channels[0]} and {len(channels) - 1} more channels"


def merge(findings: Sequence[Finding], num_runs: int) -> list[Finding]:
    """Equal faults of several runs as one, then of channels of the same runs.

    Args:
        findings: In the order of the runs.
        num_runs: Runs that could have a fault; with all of them `of_all`.
    """
    groups: dict[tuple, list[Finding]] = {}
    for f in findings:
        # A number is the same to a hundredth of itself.
        rounded = tuple((k, float(f"{v:.1e}")) for k, v in f.parameters.items())
        numbers = () if f.fault.is_of_run else rounded
        key = (f.fault.name, f.channels, numbers, f.severity)
        groups.setdefault(key, []).append(f)
    by_runs: dict[tuple, list[Finding]] = {}
    for group in groups.values():
        one = _over_runs(group, num_runs)
        key = (one.fault.name, one.runs, one.severity)
        if not one.fault.is_of_run:
            key = (*key, one.channels, tuple(one.parameters.items()))
        by_runs.setdefault(key, []).append(one)
    return [_over_channels(group) for group in by_runs.values()]


def _over_runs(group: Sequence[Finding], num_runs: int) -> Finding:
    """One fault of several runs; what is told is of the first."""
    files = tuple(dict.fromkeys(run for f in group for run in f.runs))
    return replace(
        group[0],
        runs=files,
        of_all=len(files) == num_runs and num_runs > 1,
        probability=max(f.probability for f in group),
    )


def _over_channels(group: Sequence[Finding]) -> Finding:
    """One fault of several channels of the same runs."""
    channels = tuple(dict.fromkeys(c for f in group for c in f.channels))
    return replace(group[0], channels=channels)
