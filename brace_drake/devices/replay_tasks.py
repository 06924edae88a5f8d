"""Replays of several points in several runs, shared out into tasks.

What a task holds goes side by side, see `laws.lanes`; what it holds is what a
twin may remember.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from math import gcd

from brace_drake.laws.lanes.kinds import COUNT

# Points in a task: a few times as many as go side by side.
_AT_ONCE = 2 * COUNT

# Places of runs, those of one motion together.
Groups = list[list[int]]


def group_runs(prepared: Sequence) -> list[Groups]:
    """Runs with contact, and those without, each by their motion where it can
    be told.

    Args:
        prepared: Runs, see `PreparedRun`.
    """
    found: dict[tuple, list[int]] = {}
    for i, p in enumerate(prepared):
        digest = getattr(p.motion, "digest", i)
        found.setdefault((p.run.contact, digest), []).append(i)
    return [
        [runs for (own, _), runs in found.items() if own == contact]
        for contact in (True, False)
    ]


def share_out(
    points: Sequence[int], groups: Sequence[Groups], num_lanes: int
) -> list[tuple[list[int], list[int]]]:
    """Tasks: places of runs, and which points, so that all lanes are filled.

    Args:
        points: Those that are alike in their noise follow each other.
        groups: From `group_runs`.
        num_lanes: How many replays a twin takes side by side.
    """
    tasks = []
    for start in range(0, len(points), _AT_ONCE):
        few = list(points[start : start + _AT_ONCE])
        width = num_lanes // gcd(len(few), num_lanes)
        for alike in groups:
            for at in range(0, len(alike), width):
                runs = list(chain.from_iterable(alike[at : at + width]))
                tasks.append((runs, few))
    return tasks
