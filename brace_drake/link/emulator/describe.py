"""What an emulated device says of itself."""

from __future__ import annotations

from brace_drake.link.device.device_ticks import Identity
from brace_drake.link.operation.station import describe_geometry, device_model
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.brace import BraceScenario

FIRMWARE = "emulated 1.0"
_FORCE_RANGE = 50.0


def describe_device(
    scenario: BenchScenario | BraceScenario, serial: str
) -> Identity:
    """What the device of a scenario says of itself.

    The length servo's gains are those of the bench: a device of several stages
    takes forces alone.
    """
    geometry, sensors = describe_geometry(scenario), scenario.sensors
    places = {name: tuple(p.ravel().tolist()) for name, p in geometry.items()}
    stages = len(geometry["rest"])
    return Identity(
        model=device_model(scenario),
        identity=serial,
        firmware=FIRMWARE,
        stages=stages,
        rate_hz=scenario.control.rate,
        length_resolution=sensors.leg_length_resolution,
        force_resolution=sensors.force_resolution,
        force_range=_FORCE_RANGE,
        takes_lengths=stages == 1,
        **places,
    )
