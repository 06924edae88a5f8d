"""A twin beside a device: the gap of every channel, tick by tick."""

from __future__ import annotations

import math

import numpy as np

from brace_drake.emulator.bench_plant import BenchPlant
from brace_drake.laws.control import low_pass_gain_tau
from brace_drake.operation.contact_estimate import ContactEstimate
from brace_drake.operation.control import PicControl
from brace_drake.operation.session import Row
from brace_drake.scenario.bench import BenchScenario
from brace_drake.twin.bench_rollout import CHANNELS

# Without marker noise and commands: lengths, forces, marker.
GAP_CHANNELS = CHANNELS[6:18]
# The loop carries the force's noise on; see bench floor: 1.3 to 1.8 times.
_LOOP = np.array([1.0] * 6 + [1.8] * 3 + [1.0] * 3)
_AVERAGE, _REGRESSOR_LAG = 1.0, 0.05


class TwinBeside:
    """Runs the twin on a device's reference and compares.

    Attributes:
        ratio: RMS gap of each channel over the last second, in noise floors.
        alarms: Channels out of their band now, by name.
        contact: Running estimate of stiffness and damping.
    """

    def __init__(
        self, scenario: BenchScenario, band: float = 3.0, memory: float = 20.0
    ):
        self._control = PicControl(scenario)
        self._plant = BenchPlant(scenario, seed=None)
        self._band = band
        period = scenario.control.rate**-1
        numbers = self._plant.numbers
        steps = np.repeat(numbers.resolution, [6, 3]) / math.sqrt(12.0)
        steps = np.concatenate([steps, np.zeros(3)])
        self._floor = _LOOP * np.hypot(numbers.noise_sigma, steps)
        self._mean = self._floor**2
        self._gain = low_pass_gain_tau(_AVERAGE, period)
        self._lag = low_pass_gain_tau(_REGRESSOR_LAG, period)
        self._period, self._y0 = period, None
        self._filtered = np.zeros(3)
        self._before = np.zeros(3)
        self.contact = ContactEstimate(
            numbers.contact[0:2], float(numbers.contact[5]), memory, period
        )
        self.ratio = np.ones(len(GAP_CHANNELS))
        self.alarms: list[str] = []
        self._readings = self._plant.advance(self._plant.hold).copy()

    def Take(self, row: Row) -> None:
        """Takes a tick of the device, in order: readings, reference, pose."""
        twin = self._readings
        gap = row.readings - twin
        self._mean += self._gain * (gap**2 - self._mean)
        self.ratio = np.sqrt(self._mean) / self._floor
        self._Judge()
        self._Learn(row, float(row.y_ring[0]), twin)
        command = self._control.Tick(twin, row.desired)
        self._readings = self._plant.advance(command).copy()

    def _Judge(self) -> None:
        """An alarm begins outside the band and ends well inside it."""
        for i, name in enumerate(GAP_CHANNELS):
            if self.ratio[i] > self._band and name not in self.alarms:
                self.alarms = [*self.alarms, name]
            elif self.ratio[i] < 0.8 * self._band and name in self.alarms:
                self.alarms = [a for a in self.alarms if a != name]

    def _Learn(self, row: Row, pose_y: float, twin: np.ndarray) -> None:
        mine = self._control.pose[1] - twin[10]
        raw = np.array([pose_y - row.readings[10], mine, row.readings[7]])
        self._filtered += self._lag * (raw - self._filtered)
        rate = (self._filtered - self._before) / self._period
        self._before = self._filtered.copy()
        self.contact.Update(
            (self._filtered[0], rate[0]),
            (self._filtered[1], rate[1]),
            float(self._filtered[2]),
        )

    def describe(self) -> dict:
        """What a page shows."""
        k, c = self.contact.values
        return {
            "ratio": dict(zip(GAP_CHANNELS, self.ratio.tolist(), strict=True)),
            "band": self._band,
            "alarms": self.alarms,
            "stiffness_N_m": float(k),
            "damping_N_s_m": float(c),
        }
