"""What an axis under a command, or behind its motor, is fitted by."""

from __future__ import annotations

from brace_drake.core.errors import ScenarioError
from brace_drake.devices.subject import SubjectParameter
from brace_drake.scenario.axis import AxisScenario

# Numbers may be so many times less or more than nominal.
_SPREAD = 20.0
_FEED_FORWARD = 0.0, 4.0
# So many times its loop's damping an integral's rate is at most.
_INTEGRAL = 1.0
# A load that swings as fast behind its motor is as good as rigidly joined.
FASTEST_RAD_S = 2000.0
# What a load on a spring behind its motor is fitted by.
ELASTIC = ("frequency", "damping_ratio", "viscous", "offset")
# Limits of the numbers of a spring between motor and load.
_OF_SPRING = {"frequency": (1.0, FASTEST_RAD_S), "damping_ratio": (0.0, 20.0)}


def loop_damping(scenario: AxisScenario) -> float:
    """Of the controller, 1/s."""
    if scenario.command == "speed":
        return 1.0 / scenario.lag
    return 2.0 * scenario.damping_ratio * scenario.frequency


def fitted_fields(scenario: AxisScenario) -> tuple[str, ...]:
    """Fields of the scenario that a machine is fitted by."""
    if scenario.command == "motor":
        other = {*scenario.fitted} - {*ELASTIC}
        if other:
            raise ScenarioError(
                f"fitted has {', '.join(sorted(other))}; allowed behind a"
                f" motor: {', '.join(ELASTIC)}"
            )
        return tuple(scenario.fitted)
    is_speed = scenario.command == "speed"
    loop = ("lag",) if is_speed else ("frequency", "damping_ratio")
    optional = "integral", "viscous", "feed_forward"
    more = [n for n in optional if getattr(scenario, n)]
    # What is constant an integral takes by itself.
    return (*loop, *more, *["bias"] * (not scenario.integral))


def follower_subject(scenario: AxisScenario) -> tuple[SubjectParameter, ...]:
    """Numbers of a follower that are fitted, with nominal values and limits."""
    units, found = scenario.units, []
    named = {
        "lag": ("lag_s", "s"),
        "frequency": ("frequency_rad_s", "rad/s"),
        "damping_ratio": ("damping_ratio", "1"),
        "integral": ("integral_1_s", "1/s"),
        "feed_forward": ("feed_forward", "1"),
    }
    speed, acceleration = scenario.speed_scale, scenario.acceleration_scale
    shifts = {
        "bias": (acceleration, "bias_m_s2", "m/s^2"),
        "viscous": (acceleration / speed, "viscous_N_s_m", "N s/m"),
        "offset": (scenario.length_scale, "offset_m", "m"),
    }
    for field in fitted_fields(scenario):
        value = float(getattr(scenario, field))
        if field in shifts:
            size, name, unit = shifts[field]
            name, unit = units.name(name, unit), units.unit(unit)
            most = max(size, 2.0 * abs(value))
            least = 0.0 if field == "viscous" else -most
            most *= _SPREAD if field == "viscous" else 1.0
            found.append(SubjectParameter(name, unit, value, least, most, size))
            continue
        name, unit = named[field]
        least, most = value / _SPREAD, value * _SPREAD
        if field == "integral":
            least, most = 0.0, _INTEGRAL * loop_damping(scenario)
        if field == "feed_forward":
            least, most = _FEED_FORWARD
        if scenario.command == "motor" or not value:
            least, most = _OF_SPRING[field]
            value = min(value, most)
        found.append(SubjectParameter(name, unit, value, least, most))
    return tuple(found)
