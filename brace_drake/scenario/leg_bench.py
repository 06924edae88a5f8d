"""The leg bench's scenario: one linear drive alone, under position control."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from brace_drake.recording.columns import LEG_BENCH
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.brace import EffectUse
from brace_drake.scenario.fields import items, number

# A plant step is no longer than this, s.
_LONGEST_STEP = 2e-4
# Above this part of the Nyquist frequency readings are noise alone.
_NOISE_BAND = 0.6


@dataclass(slots=True)
class DriveControl:
    """Position control: f = kv (kp (y_d - y) - y'), held between ticks.

    The velocity is the difference of the mean of two successive readings.
    With kv = 0 there is none, and the recorded command drives the bench.
    """

    rate: float = number(1000.0, "Hz", above=0.0)
    kp: float = number(160.18, "1/s", least=0.0)
    kv: float = number(8557.27, "N s/m", least=0.0)
    force_limit: float = number(351.5, "N", above=0.0)  # of the command


@dataclass(slots=True)
class LegBenchScenario:
    """One linear drive: m y'' = u - b y' - offset."""

    device: str = LEG_BENCH
    time_step: float = number(0.0002, "s", above=0.0)  # of the simulation
    mass: float = number(95.0, "kg", above=0.0)
    viscous: float = number(200.0, "N s/m", least=0.0)
    offset: float = number(0.0, "N")  # load that the command has to hold
    # Standard deviation of a reading.
    position_noise: float = number(0.0, "m", least=0.0)
    control: DriveControl = field(default_factory=DriveControl)
    effects: list[EffectUse] = items()


@dataclass(frozen=True)
class LegBenchNumbers:
    """The scenario's numbers as the laws take them.

    Attributes:
        mass: (1,), kg.
        viscous: (1,), N s/m.
        offset: (1,), N.
        control: kp, kv, limit, period (4,).
        noise_sigma: Of the position reading (1,), m.
    """

    mass: np.ndarray
    viscous: np.ndarray
    offset: np.ndarray
    control: np.ndarray
    noise_sigma: np.ndarray

    @property
    def is_closed_loop(self) -> bool:
        """Whether there is a position controller."""
        return bool(self.control[1] > 0.0)

    def with_changes(self, **arrays: np.ndarray) -> "LegBenchNumbers":
        """A copy with some arrays replaced."""
        return replace(self, **arrays)


def pack_leg_bench(scenario: LegBenchScenario) -> LegBenchNumbers:
    """Arrays of the nominal twin that a scenario describes."""
    control = scenario.control
    return LegBenchNumbers(
        mass=np.array([scenario.mass]),
        viscous=np.array([scenario.viscous]),
        offset=np.array([scenario.offset]),
        control=np.array(
            [control.kp, control.kv, control.force_limit, 1.0 / control.rate]
        ),
        noise_sigma=np.array([scenario.position_noise]),
    )


def MakeLegBenchScenario(campaign: Campaign) -> LegBenchScenario:
    """The nominal leg bench of a campaign.

    Mass and viscous friction are the campaign's `nominal`, gains and limit its
    `control`; ticks come at the recorded rate, with a whole number of plant
    steps in each. Without `control` the gains are 0. The reading noise is that
    of the recordings to be fitted.
    """
    given, period = campaign.control, 1.0 / campaign.rate_hz
    return LegBenchScenario(
        time_step=period / math.ceil(period / _LONGEST_STEP - 1e-9),
        mass=campaign.nominal["mass_kg"],
        viscous=campaign.nominal["viscous_N_s_m"],
        position_noise=estimate_position_noise(campaign.split("fit")),
        control=DriveControl(
            campaign.rate_hz,
            given.get("kp_1_s", 0.0),
            given.get("kv_N_s_m", 0.0),
            given.get("force_limit_N", math.inf),
        ),
    )


def estimate_position_noise(runs: Sequence[Run]) -> float:
    """Noise of the position readings from recordings themselves, m.

    The largest of the runs; 0 without any. The rounding of the readings, by
    the sensor or the file, is part of it.
    """
    positions = [run.channels["position_m"] for run in runs]
    return max((white_part(y) for y in positions), default=0.0)


def white_part(signal: np.ndarray) -> float:
    """Standard deviation of the white noise in a smooth signal (N,).

    From the median power in the upper band of the spectrum, to which lines
    mean nothing, under a window that keeps the motion out of that band.
    """
    window = np.blackman(len(signal))
    power = np.abs(np.fft.rfft((signal - signal.mean()) * window)) ** 2
    upper = power[int(_NOISE_BAND * len(power)) : -1]
    density = np.median(upper) / np.log(2.0)
    return float(np.sqrt(density / np.sum(window**2)))
