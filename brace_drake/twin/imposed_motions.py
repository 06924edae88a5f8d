"""Motions for one drive and for one pad, within what they were recorded at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.campaign.recording import Run
from brace_drake.twin.leg_bench_twin import LegBenchTwin
from brace_drake.twin.motion_set import MotionSet
from brace_drake.twin.pad_bench_twin import PadBenchTwin
from brace_drake.twin.recorded_reach import (
    Reach,
    Way,
    recorded_reach,
    ways_within,
)

_DESIRED, _POSITION = "position_desired_m", "position_m"
_COMMAND = "force_command_N"
_DISPLACEMENT, _FORCE = "displacement_m", "force_N"


@dataclass(frozen=True)
class ImposedMotion:
    """A way to impose; see `PlannedMotion`.

    Attributes:
        way: The positions.
        contact: As in recordings of its kind.
        column: Channel that is imposed.
        beside: Channels that tell how the run begins.
    """

    way: Way
    contact: bool
    column: str
    beside: dict[str, np.ndarray]

    @property
    def name(self) -> str:
        return self.way.name

    @property
    def meaning(self) -> str:
        return self.way.meaning

    @property
    def columns(self) -> tuple[str, ...]:
        return (self.column,)

    @property
    def run(self) -> Run:
        channels = {"time_s": self.way.time, self.column: self.way.position}
        return Run(
            f"{self.name}.csv",
            self.contact,
            self.name,
            None,
            "fit",
            channels | self.beside,
        )


def pad_motions(
    twin: PadBenchTwin, runs: Sequence[Run], rate: float
) -> MotionSet:
    """Ways of a pad, with no more force than recorded.

    Args:
        twin: Of the pad bench.
        runs: Recordings, at least one.
        rate: Of the samples, Hz.
    """
    reach = recorded_reach(runs, _DISPLACEMENT, _FORCE)
    contact = runs[0].contact
    motions = [
        ImposedMotion(way, contact, _DISPLACEMENT, {})
        for way in ways_within(reach, rate)
    ]
    column = twin.channels.index(_FORCE)

    def exceeded(twin, motion, subject, log):
        return _beyond_force(reach, log[:, column])

    return MotionSet(rate, motions, exceeded)


def leg_motions(
    twin: LegBenchTwin, runs: Sequence[Run], rate: float
) -> MotionSet | None:
    """Ways for a drive under position control; without one none is safe.

    Args:
        twin: Of the leg bench.
        runs: Recordings, at least one.
        rate: Of the samples, Hz.
    """
    if not all(twin.is_closed(run) for run in runs):
        return None
    reach = recorded_reach(runs, _DESIRED, _COMMAND)
    went = recorded_reach(runs, _POSITION, _COMMAND)
    contact = runs[0].contact
    motions = [
        ImposedMotion(way, contact, _DESIRED, _at_rest(way))
        for way in ways_within(reach, rate)
    ]
    force, position = map(twin.channels.index, (_COMMAND, _POSITION))

    def exceeded(twin, motion, subject, log):
        low, high = log[:, position].min(), log[:, position].max()
        if low < went.low or high > went.high:
            return (
                f"positions from {1e3 * low:.1f} to {1e3 * high:.1f} mm,"
                f" recorded {1e3 * went.low:.1f} to {1e3 * went.high:.1f} mm"
            )
        return _beyond_force(reach, log[:, force])

    return MotionSet(rate, motions, exceeded)


def _at_rest(way: Way) -> dict[str, np.ndarray]:
    """What a drive reads that stands where the way begins."""
    still = np.full(len(way.time), way.position[0])
    return {_POSITION: still, _COMMAND: np.zeros(len(way.time))}


def _beyond_force(reach: Reach, force: np.ndarray) -> str | None:
    largest = float(np.abs(force).max())
    if largest > reach.force:
        return f"a force of {largest:.3g} N, recorded {reach.force:.3g} N"
    return None
