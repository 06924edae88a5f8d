"""What a device may be asked for, and what no motion may pass.

The bench has limits of its own, which its twin predicts; of a drive and of a
pad nothing is known but how far their recordings reached.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.errors import LimitsError
from brace_drake.devices.bench.rollout import CHANNELS, COMMANDS
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.devices.motions.library import MotionSet, SafeMotion
from brace_drake.devices.motions.recorded_reach import (
    Reach,
    Way,
    largest_speed,
    recorded_reach,
    ways_within,
)
from brace_drake.devices.pad_bench.twin import PadBenchTwin
from brace_drake.devices.subject import with_subject
from brace_drake.recording import Run
from brace_drake.recording.columns import BENCH_RINGS

EXCURSION = 0.012  # m, of the reference
_ROUNDING = 1e-9
PAD_FORCE = 50.0  # N, of one pad

_FORCE_Y = CHANNELS.index(f"ring{BENCH_RINGS[0]}_force_y_N")

_DESIRED, _POSITION = "position_desired_m", "position_m"
_COMMAND = "force_command_N"
_DISPLACEMENT, _FORCE = "displacement_m", "force_N"
# Of the range, how far from its ends a drive begins: it may sag or swing there.
_INSIDE = 0.025


def check_reach(name: str, y: np.ndarray) -> None:
    """Refuses a reference that no device may follow.

    Args:
        name: Of the motion.
        y: Displacements of the ring along y (N,), m.

    Raises:
        LimitsError: It reaches beyond `EXCURSION`, or is no number somewhere.
    """
    reach = float(np.abs(y).max(initial=0.0))
    # Written so that what is no number is refused.
    if not reach <= EXCURSION + _ROUNDING:
        raise LimitsError(
            f"motion {name} reaches {1e3 * reach:.1f} mm, allowed"
            f" {1e3 * EXCURSION:.0f} mm"
        )


def exceeded_limit(
    twin: BenchTwin, motion: SafeMotion, subject: np.ndarray, log: np.ndarray
) -> str | None:
    """Which limit a motion passes, in words; None where it keeps them all.

    Args:
        twin: Whose legs have the limit.
        motion: The reference.
        subject: Values of the subject's parameters.
        log: The twin's recording of it (N, C).
    """
    excursion = float(np.abs(motion.samples[:, 0]).max())
    if excursion > EXCURSION:
        return f"{1e3 * excursion:.1f} mm, allowed {1e3 * EXCURSION:.0f} mm"
    pad = float(largest_pad_force(twin, subject, log[:, _FORCE_Y]).max())
    if motion.contact and pad >= PAD_FORCE:
        return f"a pad force of {pad:.0f} N, allowed {PAD_FORCE:.0f} N"
    command = float(np.abs(log[:, COMMANDS]).max())
    limit = twin.scenario.leg.force_limit
    if command >= limit:
        return f"a leg force of {command:.0f} N, allowed {limit:.0f} N"
    return None


def largest_pad_force(
    twin: BenchTwin, subject: np.ndarray, force_y: np.ndarray
) -> np.ndarray:
    """Force of the pad that presses harder (N,), N.

    The reading is the difference of both. While both touch, slowly, their sum
    is 2 k p, so that the larger is |F| / 2 + k p; else it is |F|.

    Args:
        twin: Of the bench.
        subject: Values of the subject's parameters.
        force_y: Force on the torso along y (N,), N.
    """
    contact = with_subject(twin.numbers, subject).contact
    shared = contact[0, 0] * contact[0, 5]
    return np.maximum(np.abs(force_y), 0.5 * np.abs(force_y) + shared)


@dataclass(frozen=True)
class ImposedMotion:
    """A way to impose; see `PlannedMotion`."""

    meaning: str
    run: Run
    columns: tuple[str, ...]

    @property
    def name(self) -> str:
        return self.run.name

    @property
    def contact(self) -> bool:
        return self.run.contact


def _impose(
    way: Way,
    contact: bool,
    column: str,
    beside: dict[str, np.ndarray] | None = None,
) -> ImposedMotion:
    """A way as a motion of a channel.

    Args:
        way: The positions.
        contact: As in recordings of its kind.
        column: Channel that is imposed.
        beside: Channels that tell how the run begins.
    """
    channels = {"time_s": way.time, column: way.position, **(beside or {})}
    file = f"{way.name}.csv"
    run = Run(file, contact, way.name, None, "fit", channels)
    return ImposedMotion(way.meaning, run, (column,))


def pad_motions(
    twin: PadBenchTwin, runs: Sequence[Run], rate: float
) -> MotionSet:
    """Ways of a pad, with no more force than recorded.

    Args:
        twin: Of the pad bench.
        runs: Recordings, at least one; where one touches, those that do.
        rate: Of the samples, Hz.
    """
    runs = _of_one_kind(runs)
    reach = recorded_reach(runs, _DISPLACEMENT, _FORCE)
    motions = [
        _impose(way, runs[0].contact, _DISPLACEMENT)
        for way in ways_within(reach, rate)
    ]
    force = twin.channels.index(_FORCE)

    def exceeded(_twin, _motion, _subject, log):
        return _beyond_force(reach, log[:, force])

    return MotionSet(rate, motions, exceeded)


def leg_motions(
    twin: LegBenchTwin, runs: Sequence[Run], rate: float
) -> MotionSet | None:
    """Ways for a drive under position control; without one none is safe.

    The drive has to keep within its own recorded positions and speeds, and
    below the control's limit of force.

    Args:
        twin: Of the leg bench.
        runs: Recordings, at least one; where one touches, those that do.
        rate: Of the samples, Hz.
    """
    runs = _of_one_kind(runs)
    if not all(twin.is_closed(run) for run in runs):
        return None
    went = recorded_reach(runs, _POSITION, _COMMAND)
    asked = _within(recorded_reach(runs, _DESIRED, _COMMAND), went)
    motions = [
        _impose(way, runs[0].contact, _DESIRED, _at_rest(way, runs))
        for way in ways_within(asked, rate)
    ]
    force, position = map(twin.channels.index, (_COMMAND, _POSITION))
    limit = float(twin.numbers.control[2])

    def exceeded(_twin, _motion, _subject, log):
        return (
            _beyond_range(went, log[:, position])
            or _beyond_speed(went, log[:, position], rate)
            or _beyond_force(went, log[:, force], limit)
        )

    return MotionSet(rate, motions, exceeded)


def _of_one_kind(runs: Sequence[Run]) -> list[Run]:
    """Those in contact, or all where none is."""
    contact = any(run.contact for run in runs)
    return [run for run in runs if run.contact == contact]


def _within(asked: Reach, went: Reach) -> Reach:
    """What was asked for, as far as the drive went, from inside of it."""
    low, high = max(asked.low, went.low), min(asked.high, went.high)
    inside = _INSIDE * max(high - low, 0.0)
    start = float(np.clip(asked.start, low + inside, max(high - inside, low)))
    return replace(asked, start=start, low=low, high=high)


def _at_rest(way: Way, runs: Sequence[Run]) -> dict[str, np.ndarray]:
    """What a drive reads that stands where the way begins."""
    command = float(np.median([run.channels[_COMMAND][0] for run in runs]))
    size = len(way.time)
    return {
        _POSITION: np.full(size, way.position[0]),
        _COMMAND: np.full(size, command),
    }


def _beyond_range(went: Reach, position: np.ndarray) -> str | None:
    low, high = float(position.min()), float(position.max())
    if low >= went.low and high <= went.high:
        return None
    return (
        f"positions from {1e3 * low:.1f} to {1e3 * high:.1f} mm, recorded"
        f" {1e3 * went.low:.1f} to {1e3 * went.high:.1f} mm"
    )


def _beyond_speed(went: Reach, position: np.ndarray, rate: float) -> str | None:
    speed = largest_speed(np.arange(len(position)) / rate, position)
    if speed <= went.speed:
        return None
    return f"{speed:.3g} m/s, recorded {went.speed:.3g} m/s"


def _beyond_force(
    reach: Reach, force: np.ndarray, limit: float = np.inf
) -> str | None:
    """Also where a drive is at its limit, which hides what it would need."""
    largest = float(np.abs(force).max())
    if largest <= reach.force and largest < limit:
        return None
    return f"a force of {largest:.3g} N, recorded {reach.force:.3g} N"
