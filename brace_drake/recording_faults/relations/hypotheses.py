"""Faults of a recording that could make commands and readings disagree."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from brace_drake.devices.declaration import ControlLaw
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.card import RecordingFault
from brace_drake.recording_faults.channels import desired_channels
from brace_drake.recording_faults.library.channels import (
    exchanged_channels,
    permuted_channels,
)
from brace_drake.recording_faults.statistics import has_signal

# What channels are named by: those of a leg differ in its number alone.
_COMMAND, _LENGTH = "_force_command_N", "_length_m"


@dataclass(frozen=True)
class Hypothesis:
    """One fault with its channels and parameters."""

    fault: RecordingFault
    channels: tuple[str, ...]
    parameters: Mapping[str, float]

    def undone(self, run: Run) -> Run:
        """The run as it would be without the fault."""
        columns = self.fault.undo(run.channels, self.channels, self.parameters)
        return replace(run, channels=columns)


def legs_of(run: Run) -> list[str]:
    """Legs of which lengths were recorded, in the order of their numbers."""
    names = [
        n.removesuffix(_LENGTH) for n in run.channels if n.endswith(_LENGTH)
    ]
    legs = [n for n in names if n.startswith("leg")]
    return sorted(legs, key=lambda n: (len(n), n))


def groups_of(run: Run, kind: str) -> list[str]:
    """Channels of one kind of all legs."""
    names = [leg + kind for leg in legs_of(run)]
    return [n for n in names if n in run.channels]


def channels_of(law: ControlLaw, run: Run) -> list[str]:
    """Recorded channels that a law computes or reads, each once."""
    names = dict.fromkeys((*law.outputs, *itertools.chain(*law.by_output)))
    return [n for n in names if n in run.channels]


def exchanges(run: Run, law: ControlLaw) -> Iterator[Hypothesis]:
    """Pairs of channels in each other's column; none that gives the law noise
    alone for a reading: that hides any error.
    """
    read = {n for names in law.by_output for n in names}
    for h in _exchanges(run, law):
        half = len(h.channels) // 2
        pairs = [*zip(h.channels, h.channels[half:], strict=False)]
        pairs += [(b, a) for a, b in pairs]
        given = [b for a, b in pairs if a in read]
        if all(has_signal(run.channels[n]) for n in given):
            yield h


def _exchanges(run: Run, law: ControlLaw) -> Iterator[Hypothesis]:
    """Pairs of channels in each other's column.

    Lengths, commands and whole legs; forces among themselves; the virtual
    position and the reference; where there is one output alone, any two.
    """
    card = exchanged_channels.CARD
    for kind in (_LENGTH, _COMMAND):
        for pair in itertools.combinations(groups_of(run, kind), 2):
            yield Hypothesis(card, pair, {})
    commands = groups_of(run, _COMMAND)
    if commands:
        for a, b in itertools.combinations(legs_of(run), 2):
            first, second = (
                (a + _LENGTH, a + _COMMAND),
                (b + _LENGTH, b + _COMMAND),
            )
            yield Hypothesis(card, (*first, *second), {})
    forces = [
        n for n in run.channels if n.startswith("ring") and "_force_" in n
    ]
    for pair in itertools.combinations(forces, 2):
        if any("_force_y_" in n for n in pair):
            yield Hypothesis(card, pair, {})
    rings = [
        n for n in run.channels if n.startswith("ring") and n.endswith("_m")
    ]
    for pair in itertools.combinations(rings, 2):
        yield Hypothesis(card, pair, {})
    for leg_length, leg_command in zip(
        groups_of(run, _LENGTH), commands, strict=False
    ):
        yield Hypothesis(card, (leg_length, leg_command), {})
    if len(law.outputs) == 1:
        alone = [*channels_of(law, run), *desired_channels(run)]
        for pair in itertools.combinations(alone, 2):
            yield Hypothesis(card, pair, {})


def permutations(run: Run) -> Iterator[Hypothesis]:
    """Legs counted from another one, or the other way round."""
    card = permuted_channels.CARD
    size = len(legs_of(run))
    for kind in (_LENGTH, _COMMAND):
        names = tuple(groups_of(run, kind))
        if len(names) < 3:
            continue
        for reverse in (0.0, 1.0):
            for shift in range(size):
                if reverse or shift:
                    values = {"shift": float(shift), "reversed": reverse}
                    yield Hypothesis(card, names, values)


def singles(run: Run, law: ControlLaw) -> list[tuple[str, ...]]:
    """Channels, and groups of them, that one fault may have alike."""
    groups = [groups_of(run, kind) for kind in (_LENGTH, _COMMAND)]
    found: list[tuple[str, ...]] = [(n,) for n in channels_of(law, run)]
    return found + [tuple(g) for g in groups if len(g) > 1]


def late_groups(run: Run, law: ControlLaw) -> list[tuple[str, ...]]:
    """Channels that one recorder may have written late."""
    found = singles(run, law)
    asked = desired_channels(run)
    return [*found, tuple(asked)] if asked else found
