"""What the device of a scenario says of itself."""

from __future__ import annotations

from brace_drake.link.device.ticks import Identity
from brace_drake.recording.columns import BENCH, BRACE
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_geometry

FIRMWARE = "emulated 1.0"
_FORCE_RANGE = 50.0


def describe_device(scenario: BraceScenario, serial: str = "") -> Identity:
    """What the device of a scenario says of itself; stage 2 is the bench.

    The length servo's gains are those of the bench: a device of several stages
    takes forces alone.
    """
    stages, sensors = scenario.stages, scenario.sensors
    geometry = pack_geometry(scenario)
    # Anchors are told in their own rings.
    lower = geometry.lower.copy()
    lower[0, :, 2] -= scenario.ring_heights[stages[0] - 1]
    return Identity(
        model=BENCH if stages == [2] else BRACE,
        identity=serial,
        firmware=FIRMWARE,
        stages=len(stages),
        rate_hz=scenario.control.rate,
        length_resolution=sensors.leg_length_resolution,
        force_resolution=sensors.force_resolution,
        force_range=_FORCE_RANGE,
        takes_lengths=len(stages) == 1,
        rest=tuple(geometry.rest.ravel().tolist()),
        lower=tuple(lower.ravel().tolist()),
        upper=tuple(geometry.upper.ravel().tolist()),
    )
