"""Which channels each device records, and what values they can hold."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

# Longest first, so that "m_s2" is not taken for "s2" after "m".
_UNITS = (
    *("mm_s2", "cm_s2", "m_s2", "mm_s", "cm_s", "m_s"),
    *("kgf", "lbf", "min", "deg", "rad", "ms", "us", "mm", "cm", "um"),
    *("mN", "kN", "cN", "s", "m", "N", "g"),
)

_AXES = "xyz"


@dataclass(frozen=True)
class Channel:
    """One column of a recording.

    Attributes:
        name: Column name; its last part is the unit.
        low: Least plausible value, in the channel's unit.
        high: Greatest plausible value, in the channel's unit.
        constant: When the channel may stay at one value: "never",
            "always", "free" (the torso is absent) or "still" (the channel
            `reference` does not move).
        reference: The desired motion that drives this channel, if any.
        saturates: Which limit clips it: "command", "reading" or None.
        is_input: Whether a repeat must show the same values again.
        required: Whether a recording without it is unusable.
        is_optional: Whether a recording without it misses nothing.
    """

    name: str
    low: float
    high: float
    constant: str = "never"
    reference: str | None = None
    saturates: str | None = None
    is_input: bool = False
    required: bool = True
    is_optional: bool = False

    @property
    def unit(self) -> str:
        """Unit as written in the name, such as "m_s2"."""
        return split_unit(self.name)[1]


def split_unit(name: str) -> tuple[str, str]:
    """Splits a column name into quantity and unit ("" when it has none)."""
    for unit in _UNITS:
        if name.endswith(f"_{unit}"):
            return name[: -len(unit) - 1], unit
    return name, ""


def near_miss(name: str, header: Iterable[str]) -> str | None:
    """The column of `header` that holds `name` in another unit or case."""
    quantity = split_unit(name)[0].lower()
    for candidate in header:
        if split_unit(candidate)[0].lower() == quantity:
            return candidate
    return None


def _time() -> Channel:
    # A run lasts minutes: larger values are clock time, or milliseconds.
    return Channel("time_s", -1.0, 1e5)


def _leg(k: int) -> list[Channel]:
    # A leg of 0.09 to 0.2 m: millimetres and centimetres fall outside.
    return [
        Channel(
            f"leg{k}_force_command_N",
            -1000.0,
            1000.0,
            saturates="command",
            required=False,
        ),
        Channel(f"leg{k}_length_m", 0.03, 0.5),
    ]


def _ring(i: int) -> list[Channel]:
    y_d = f"ring{i}_y_desired_m"
    driven = {"constant": "still", "reference": y_d}
    forces = [
        Channel(
            f"ring{i}_force_{axis}_N",
            -1000.0,
            1000.0,
            constant="free",
            saturates="reading",
        )
        for axis in _AXES
    ]
    return [
        *forces,
        Channel(y_d, -0.2, 0.2, constant="always", is_input=True),
        Channel(f"ring{i}_vy_desired_m_s", -2.0, 2.0, **driven),
        Channel(f"ring{i}_ay_desired_m_s2", -50.0, 50.0, **driven),
        Channel(f"ring{i}_y_virtual_m", -0.2, 0.2, required=False, **driven),
    ]


def _torso() -> list[Channel]:
    return [
        Channel(f"torso_{axis}_m", -0.2, 0.2, constant="free", required=False)
        for axis in _AXES
    ]


def _stages(legs: Iterable[int], rings: Iterable[int]) -> list[Channel]:
    return [
        _time(),
        *(channel for k in legs for channel in _leg(k)),
        *(channel for i in rings for channel in _ring(i)),
        *_torso(),
    ]


def _leg_bench() -> list[Channel]:
    given = {"constant": "always", "is_input": True}
    given |= {"required": False, "is_optional": True}
    return [
        _time(),
        Channel("force_command_N", -1000.0, 1000.0, saturates="command"),
        Channel("position_m", -2.0, 2.0),
        Channel("position_desired_m", -2.0, 2.0, **given),
        Channel("external_force_N", -1000.0, 1000.0, **given),
    ]


def _pad_bench() -> list[Channel]:
    return [
        _time(),
        Channel("displacement_m", -0.2, 0.2),
        Channel("force_N", -1000.0, 1000.0),
    ]


def _by_name(channels: list[Channel]) -> dict[str, Channel]:
    return {channel.name: channel for channel in channels}


BENCH = "bench stage 2"
BRACE = "brace"
LEG_BENCH = "leg bench"
PAD_BENCH = "pad bench"

DEVICES: dict[str, dict[str, Channel]] = {
    BENCH: _by_name(_stages(range(1, 7), [2])),
    BRACE: _by_name(_stages(range(1, 19), [1, 2, 3])),
    LEG_BENCH: _by_name(_leg_bench()),
    PAD_BENCH: _by_name(_pad_bench()),
}
BRACE_STAGES = (1, 2, 3)


def device_channels(
    device: str | None, stages: Iterable[int] = ()
) -> dict[str, Channel]:
    """Channels of a device; those of some stages, where a brace has them.

    Args:
        device: A key of DEVICES; anything else has no channels.
        stages: Of a brace, the stages that were recorded; none: all.
    """
    if device != BRACE or not stages:
        return DEVICES.get(device, {})
    legs = [6 * (i - 1) + k for i in stages for k in range(1, 7)]
    return _by_name(_stages(legs, stages))
