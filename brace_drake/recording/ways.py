"""Sets of columns of which all runs of a campaign need one.

An axis is told by its columns: whether it goes along a line or turns, what it
is given, and what of its motion was recorded.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from brace_drake.recording.findings import Problem, error, warning

# Columns of a recording beyond these are not named in a message.
_MOST_NAMES = 6


def speed_column(kind: str) -> str:
    """Column of an axis' speed; kind: linear or rotary."""
    return "speed_rad_s" if kind == "rotary" else "speed_m_s"


def axis_columns(kind: str, command: str = "motion") -> tuple[str, str]:
    """Columns of an axis' position, and of the force that moves it or of what
    it is commanded.

    Args:
        kind: linear or rotary.
        command: motion where that is imposed and a force was measured, force
            where that was commanded, motor where the motor's own motion was
            measured too, else speed or position.
    """
    is_rotary = kind == "rotary"
    unit = "rad" if is_rotary else "m"
    moved_by = {
        "motion": "torque_N_m" if is_rotary else "force_N",
        "force": "torque_command_N_m" if is_rotary else "force_command_N",
        "speed": f"speed_command_{unit}_s",
        "position": f"position_command_{unit}",
        "motor": f"motor_position_{unit}",
    }
    return f"position_{unit}", moved_by[command]


@dataclass(frozen=True)
class AxisWay:
    """How an axis is moved, and what of its motion was recorded.

    Attributes:
        kind: linear or rotary.
        command: See `axis_columns`.
        answer: position or speed.
    """

    kind: str
    command: str
    answer: str

    @property
    def columns(self) -> tuple[str, str]:
        """Of the motion, and of what moves it."""
        position, moved_by = axis_columns(self.kind, self.command)
        is_speed = self.answer == "speed"
        return speed_column(self.kind) if is_speed else position, moved_by


# The first that all runs have is taken: a command of motion comes before the
# motor's motion, and this before a force that was measured beside it.
AXIS_WAYS = (
    *(
        AxisWay(kind, command, "position")
        for command in ("speed", "position", "motor", "motion", "force")
        for kind in ("linear", "rotary")
    ),
    *(AxisWay(kind, "speed", "speed") for kind in ("linear", "rotary")),
)


def describe_ways(ways: Sequence[Sequence[str]]) -> str:
    """Such as "a and b, or c and d"."""
    return ", or ".join(" and ".join(way) for way in ways)


def check_ways(
    ways: Sequence[Sequence[str]],
    runs: Mapping[str, Collection[str]],
    manifest: str,
) -> list[Problem]:
    """What keeps all runs from having one set of columns, and a warning of
    what is not used beside it.

    Args:
        ways: The sets; none: nothing is asked.
        runs: Columns of each run, by file.
        manifest: What is to blame where each run has a set of its own.
    """
    if not ways or not runs:
        return []
    shared = set.intersection(*({*own} for own in runs.values()))
    taken = next((way for way in ways if {*way} <= shared), None)
    if taken is not None:
        return _not_used(taken, ways, shared, manifest)
    allowed = describe_ways(ways)
    problems = [
        error(
            file,
            f"no columns to compare, it has {_listed(own)}; allowed: {allowed}",
        )
        for file, own in runs.items()
        if not any({*way} <= {*own} for way in ways)
    ]
    if problems:
        return problems
    return [error(manifest, f"runs differ; allowed: {allowed} in all runs")]


def _not_used(taken, ways, shared, manifest: str) -> list[Problem]:
    other = {name for way in ways for name in way if name in shared} - {*taken}
    if not other:
        return []
    names, both = ", ".join(sorted(other)), " and ".join(taken)
    return [warning(manifest, f"not used: {names}; the twin takes {both}")]


def _listed(names: Collection[str]) -> str:
    shown = [*names][:_MOST_NAMES]
    return ", ".join(shown) + (", ..." if len(names) > _MOST_NAMES else "")
