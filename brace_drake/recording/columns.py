"""Which channels each device records, and what values they can hold."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from brace_drake.core.errors import closest
from brace_drake.core.reading import HUGE
from brace_drake.recording.ways import AXIS_WAYS

# Longest first, so that "m_s2" is not taken for "s2" after "m".
# Units of numbers, as names end in them and as readers have them.
_COMPOUND = {
    "N_m_s_rad": "N m s/rad", "N_m_rad": "N m/rad", "N_s_m": "N s/m",
    "N_m": "N m", "kg_m2": "kg m^2", "kg": "kg",
}  # fmt: skip
_UNITS = (
    *_COMPOUND,
    *("mm_s2", "cm_s2", "m_s2", "rad_s", "mm_s", "cm_s", "m_s"),
    *("kgf", "lbf", "min", "deg", "rad", "ms", "us", "mm", "cm", "um"),
    *("mN", "kN", "cN", "s", "m", "N", "g"),
)

_AXES = "xyz"
# Columns so much alike are one, misspelt.
_MISSPELT = 0.85
# What tells columns of one kind apart: a number, or an axis.
MARKS = re.compile(r"\d+|(?<=_)[xyz](?=_)")


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
        is_way: Whether it is the motion that the others answer to.
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
    is_way: bool = False

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


def shown_unit(unit: str) -> str:
    """A unit of a column as readers have it: "rad/s" for "rad_s"."""
    if unit in _COMPOUND:
        return _COMPOUND[unit]
    return unit.replace("_s2", "/s^2").replace("_s", "/s").replace("_", " ")


def near_misses(
    names: Iterable[str], header: Iterable[str]
) -> dict[str, str | None]:
    """The column of `header` that holds each name in another unit or case, or
    misspelt; None where there is none.
    """
    quantities: dict[str, str] = {}
    there = list(header)
    for candidate in there:
        quantities.setdefault(split_unit(candidate)[0].lower(), candidate)
    found = {}
    for name in names:
        # Another leg, ring or axis is no misspelling.
        alike = [n for n in there if MARKS.findall(n) == MARKS.findall(name)]
        found[name] = quantities.get(
            split_unit(name)[0].lower(), closest(name, alike, _MISSPELT)
        )
    return found


# A run may begin at any time of a clock. Beyond these a float would round it to
# microseconds, and they are no seconds: milliseconds since 1970 are 1e12.
LATEST_S = 1e10
_TIME = Channel("time_s", -LATEST_S, LATEST_S, constant="always")
# Given to the device, not read from it.
_GIVEN = {
    "constant": "always",
    "is_input": True,
    "required": False,
    "is_optional": True,
}


def _stages(legs: Iterable[int], rings: Iterable[int]) -> dict[str, Channel]:
    """Channels of some stages and the torso, by name."""
    channels = [_TIME]
    for k in legs:
        command, length = f"leg{k}_force_command_N", f"leg{k}_length_m"
        # A leg of 0.09 to 0.2 m: millimetres and centimetres fall outside.
        channels += [
            Channel(command, -1e3, 1e3, saturates="command", required=False),
            Channel(length, 0.03, 0.5),
        ]
    for i in rings:
        y_d = f"ring{i}_y_desired_m"
        driven = {"constant": "still", "reference": y_d}
        channels += [
            Channel(
                f"ring{i}_force_{axis}_N",
                -1e3,
                1e3,
                constant="free",
                saturates="reading",
            )
            for axis in _AXES
        ]
        channels += [
            Channel(y_d, -0.2, 0.2, constant="always", is_input=True),
            Channel(f"ring{i}_vy_desired_m_s", -2.0, 2.0, **driven),
            Channel(f"ring{i}_ay_desired_m_s2", -50.0, 50.0, **driven),
            Channel(
                f"ring{i}_y_virtual_m", -0.2, 0.2, required=False, **driven
            ),
        ]
    channels += [
        Channel(f"torso_{a}_m", -0.2, 0.2, constant="free", required=False)
        for a in _AXES
    ]
    return {channel.name: channel for channel in channels}


@dataclass(frozen=True)
class Device:
    """What the campaigns of a device hold.

    Attributes:
        channels: By name.
        nominal: Its nominal numbers, and whether each must be there.
        control: Numbers of its controller, likewise where one is described.
        stages: Those of which a campaign may name some, from the lowest up.
        may_be_none: Whether a number may be stated as 0: it is not there.
        inputs: What names of extra inputs, of any unit, begin with; empty
            where there are none.
        has_ports: Whether a campaign says itself which columns there are.
        ways: Columns of which all runs must have one set, as a device has them
            that may be moved and read in several ways; empty for others.
    """

    channels: dict[str, Channel]
    nominal: dict[str, bool] = field(default_factory=dict)
    control: dict[str, bool] = field(default_factory=dict)
    stages: tuple[int, ...] = ()
    may_be_none: bool = False
    inputs: str = ""
    has_ports: bool = False
    ways: tuple[tuple[str, ...], ...] = ()

    def has_channel(self, name: str) -> bool:
        """Whether a recording may have a channel of that name."""
        is_input = self.inputs and name.startswith(self.inputs)
        return name in self.channels or bool(is_input) or self.has_ports


BENCH = "bench stage 2"
BRACE = "brace"
LEG_BENCH = "leg bench"
PAD_BENCH = "pad bench"
AXIS = "axis"
DIAGRAM = "diagram"
BRACE_STAGES = (1, 2, 3)
# Ring i sits above stage i; the bench has the middle one.
BENCH_RINGS = (2,)

_LEG_BENCH = (
    _TIME,
    Channel("force_command_N", -1e3, 1e3, saturates="command"),
    Channel("position_m", -2.0, 2.0),
    Channel("position_desired_m", -2.0, 2.0, **_GIVEN),
    Channel("external_force_N", -1e3, 1e3, **_GIVEN),
)
_PAD_BENCH = (
    _TIME,
    Channel("displacement_m", -0.2, 0.2, is_way=True),
    Channel("force_N", -1e3, 1e3),
)
# An axis is as large as it is: only what is no number at all is refused.
_ANY = {"low": -HUGE, "high": HUGE, "required": False, "is_optional": True}
_AXIS = (
    _TIME,
    Channel("position_m", is_way=True, **_ANY),
    Channel("position_rad", is_way=True, **_ANY),
    Channel("speed_m_s", **_ANY),
    Channel("speed_rad_s", **_ANY),
    Channel("motor_position_m", is_way=True, **_ANY),
    Channel("motor_position_rad", is_way=True, **_ANY),
    Channel("force_N", **_ANY),
    Channel("torque_N_m", **_ANY),
    Channel("force_command_N", **_ANY),
    Channel("torque_command_N_m", **_ANY),
    *(
        Channel(name, constant="always", is_input=True, **_ANY)
        for name in (
            *("speed_command_m_s", "speed_command_rad_s"),
            *("position_command_m", "position_command_rad"),
        )
    ),
)
DEVICES = {
    BENCH: Device(_stages(range(1, 7), BENCH_RINGS)),
    BRACE: Device(_stages(range(1, 19), BRACE_STAGES), stages=BRACE_STAGES),
    LEG_BENCH: Device(
        {channel.name: channel for channel in _LEG_BENCH},
        nominal={"mass_kg": True, "viscous_N_s_m": True},
        control={"kp_1_s": True, "kv_N_s_m": True, "force_limit_N": False},
    ),
    PAD_BENCH: Device(
        {channel.name: channel for channel in _PAD_BENCH},
        nominal={"stiffness_N_m": False, "damping_N_s_m": False},
    ),
    AXIS: Device(
        {channel.name: channel for channel in _AXIS},
        nominal=dict.fromkeys(
            ("mass_kg", "viscous_N_s_m", "stiffness_N_m"), False
        ),
        may_be_none=True,
        inputs="input_",
        ways=tuple(way.columns for way in AXIS_WAYS),
    ),
    # Its campaign says which columns there are.
    DIAGRAM: Device({_TIME.name: _TIME}, has_ports=True),
}


def device_channels(
    device: str, stages: Iterable[int] = ()
) -> dict[str, Channel]:
    """Channels of a device; those of some stages, where a brace has them.

    Args:
        device: A key of DEVICES; anything else has no channels.
        stages: Of a brace, the stages that were recorded; none: all.
    """
    if device != BRACE or not stages:
        return DEVICES[device].channels if device in DEVICES else {}
    legs = [6 * (i - 1) + k for i in stages for k in range(1, 7)]
    return _stages(legs, stages)


def port_channels(
    columns: Iterable[str], commands: Iterable[str]
) -> dict[str, Channel]:
    """Channels of a diagram's recordings, of any unit.

    Args:
        columns: All that its campaign names.
        commands: Those of them that go in.
    """
    sent = set(commands)
    kind = {"low": -HUGE, "high": HUGE, "constant": "always"}
    own = {n: Channel(n, is_input=n in sent, **kind) for n in columns}
    return {_TIME.name: _TIME, **own}
