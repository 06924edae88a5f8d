"""Readings that stand still while others of their stage travel.

A ring that is held leaves its stage's legs where they are: so travel is counted
stage by stage.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from brace_drake.link.device.guards import LEGS, Trip
from brace_drake.link.protocol.words import Cause


def check_stuck(
    most: float,
    origin: Sequence[float],
    before: Sequence[float],
    moved: Sequence[bool],
    length: Sequence[float],
) -> Trip | None:
    """A leg that stood still while another of its stage went too far.

    Args:
        most: The limit `stuck_travel`, m.
        origin: Lengths from which travel is counted (n,), m.
        before: Readings of the last tick (n,), m.
        moved: Which have changed since they were at `origin` (n,).
        length: Readings (n,), m.
    """
    for stage in _stages(length):
        travel = _travel(origin[stage], length[stage])
        if travel <= most:
            continue
        for k in range(stage.start, stage.stop):
            if not moved[k] and length[k] == before[k]:
                return Trip(Cause.STUCK_LEG, k, travel, most)
    return None


def count_travel(
    most: float,
    origin: tuple[float, ...],
    before: tuple[float, ...],
    moved: tuple[bool, ...],
    length: tuple[float, ...],
) -> tuple[tuple[float, ...], tuple[bool, ...]]:
    """Takes a tick's readings.

    Args:
        most ... length: As `check_stuck` takes them.

    Returns:
        Origin and moved; where a stage has gone far enough, it begins anew.
    """
    begins: tuple[float, ...] = ()
    changed: tuple[bool, ...] = ()
    for stage in _stages(length):
        own = length[stage]
        if _travel(origin[stage], own) > most:
            begins += own
            changed += (False,) * len(own)
            continue
        begins += origin[stage]
        pairs = zip(moved[stage], before[stage], own, strict=True)
        changed += tuple(m or b != a for m, a, b in pairs)
    return begins, changed


def _stages(length: Sequence[float]) -> Iterator[slice]:
    """The legs of each stage."""
    for k in range(0, len(length), LEGS):
        yield slice(k, k + LEGS)


def _travel(origin: Sequence[float], length: Sequence[float]) -> float:
    return max(abs(b - a) for a, b in zip(origin, length, strict=True))
