"""A device in one file: an oven, its heater in, its thermometer out."""

import copy
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from brace_drake.devices.declaration import Device, MotionSignals
from brace_drake.devices.registry import DeviceCard
from brace_drake.devices.subject import SubjectParameter
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.series import pass_series
from brace_drake.recording.columns import Channel
from brace_drake.recording.columns import Device as Recorded
from brace_drake.scenario.brace import EffectUse
from brace_drake.scenario.fields import items, number

HEATER, READING = "heater_W", "temperature_K"


@dataclass(slots=True)
class OvenScenario:
    """T T' = R u - T, the temperature above the room's."""

    device: str = "oven"
    time_step: float = number(0.05, "s", above=0.0)
    lag: float = number(2.0, "s", above=0.0)
    resistance: float = number(0.5, "K/W", above=0.0)
    noise: float = number(0.02, "K", above=0.0)
    effects: list[EffectUse] = items()


@dataclass(frozen=True)
class OvenNumbers:
    """Of the law, in SI."""

    lag: float
    resistance: float


class OvenTwin(ReplayTwin):
    """Heats as recorded."""

    device = "oven"
    channels: ClassVar = (READING,)
    has_loop = False

    def __init__(self, scenario, time_step=None):
        numbers = OvenNumbers(scenario.lag, scenario.resistance)
        super().__init__(scenario, numbers, time_step)
        self.subject = (
            SubjectParameter("lag_s", "s", scenario.lag, 0.5, 8.0),
            SubjectParameter(
                "resistance_K_W", "K/W", scenario.resistance, 0.1, 2.0
            ),
        )

    def coarse(self):
        """The same: a replay costs nothing."""
        return self

    def scenario_of(self, subject):
        """A copy with a subject's numbers."""
        out = copy.deepcopy(self.scenario)
        out.lag, out.resistance = map(float, subject)
        return out

    def with_subject(self, values):
        """Numbers of a subject."""
        return replace(self.numbers, lag=values[0], resistance=values[1])

    def motion(self, run):
        """What the heater gave, and the time between two samples."""
        step = float(np.median(np.diff(run.time_s)))
        return run.channels[HEATER], step

    def _replay(self, numbers, motion, subject, uses, generator):
        heat, step = motion
        keep = np.exp(-step / numbers.lag)
        gain = numbers.resistance * (1.0 - keep)
        true = lfilter([0.0, gain], [1.0, -keep], heat)
        read = pass_series(true, step, 1.0, uses)
        if generator is not None:
            noise = generator.standard_normal(len(read))
            read = read + self.scenario.noise * noise
        return read[:, None]


class Oven(Device):
    """What a diagnosis asks of an oven."""

    def __init__(self, campaign, scenario=None):
        twin = OvenTwin(scenario or OvenScenario())
        super().__init__(twin, campaign.rate_hz, [])
        self.words = {"temperature_error_K": ("Temperature", "K")}

    def quantities(self, x):
        """The temperature."""
        return {"temperature_error_K": x}

    def motion_signals(self, prepared, subject):
        """Phases are those of the temperature."""
        way = prepared.measured[:, 0]
        return MotionSignals(way, None, None, way, "temperature")

    def motions(self, runs):
        """None is known to be safe."""
        return None


CARD = DeviceCard(
    name="oven",
    recorded=Recorded(
        {
            "time_s": Channel("time_s", -1.0, 1e5, constant="always"),
            HEATER: Channel(HEATER, 0.0, 1e4, is_input=True),
            READING: Channel(READING, -100.0, 2000.0),
        }
    ),
    device=Oven,
    schema=OvenScenario,
    places=frozenset({"signal", "reading of a port"}),
)
