"""The device of a scenario: its moving rings, and what it says of itself."""

from __future__ import annotations

import numpy as np

from brace_drake.link.device.ticks import Identity
from brace_drake.recording.columns import BENCH, BRACE
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_geometry

FIRMWARE = "emulated 1.0"
_FORCE_RANGE = 50.0


def moving_rings(scenario: BraceScenario) -> tuple[int, ...]:
    """Numbers of a device's moving rings, bottom to top."""
    return tuple(scenario.stages)


def describe_device(scenario: BraceScenario, serial: str = "") -> Identity:
    """What the device of a scenario says of itself; stage 2 is the bench.

    The length servo's gains are those of the bench: a device of several stages
    takes forces alone.
    """
    rings, sensors = moving_rings(scenario), scenario.sensors
    places = {
        name: tuple(p.ravel().tolist())
        for name, p in _describe_geometry(scenario).items()
    }
    return Identity(
        model=BENCH if rings == (2,) else BRACE,
        identity=serial,
        firmware=FIRMWARE,
        stages=len(rings),
        rate_hz=scenario.control.rate,
        length_resolution=sensors.leg_length_resolution,
        force_resolution=sensors.force_resolution,
        force_range=_FORCE_RANGE,
        takes_lengths=len(rings) == 1,
        **places,
    )


def _describe_geometry(
    scenario: BraceScenario,
) -> dict[str, np.ndarray]:
    """Rest (S, 3), lower and upper anchors (6 S, 3) in their rings, m."""
    geometry = pack_geometry(scenario)
    lower = geometry.lower.copy()
    lower[0, :, 2] -= scenario.ring_heights[scenario.stages[0] - 1]
    return {"rest": geometry.rest, "lower": lower, "upper": geometry.upper}
