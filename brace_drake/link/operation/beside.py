"""A twin beside a device: the gap of every channel, tick by tick."""

from __future__ import annotations

import math

import numpy as np

from brace_drake.laws.control.impedance import low_pass_gain_tau
from brace_drake.link.emulator.make import MakePlant
from brace_drake.link.operation.contact_estimate import ContactEstimate
from brace_drake.link.operation.motion import RING
from brace_drake.link.operation.rows import Row, reading_names
from brace_drake.link.operation.station import MakeControl
from brace_drake.link.protocol.limits import DEFAULT, Limits
from brace_drake.scenario.brace import BraceScenario

# The floor is measured on the twin itself, with noise, at rest: so many ticks
# are left out, so many count, and the draws are always the same.
_SETTLE, _COUNT, _SEED = 500, 1000, 20
_AVERAGE, _REGRESSOR_LAG = 1.0, 0.05


class TwinBeside:
    """Runs the twin on a device's reference and compares.

    Attributes:
        channels: Names of what is compared: lengths, forces, marker.
        ratio: RMS gap of each over the last second, in noise floors.
        alarms: Channels out of their band now, by name.
        contact: Running estimate of stiffness and damping of a ring's pads.
        readings: Those of device and twin that were compared last.
        signals: Of the last tick, by name, device's and twin's.
        difference: Device less twin at the last tick: commands, readings,
            virtual places of the rings (16 S + 3,).
        time: Of it, from the motion's beginning, s.
    """

    def __init__(
        self,
        scenario: BraceScenario,
        band: float = 3.0,
        memory: float = 20.0,
        limits: Limits = DEFAULT,
        ring: int = RING,
    ):
        """Begins at rest, like its device.

        Args:
            scenario: Of the twin.
            band: Noise floors beyond which a channel raises an alarm.
            memory: Of the contact's estimate, s.
            limits: Of the stiffness that a controller sets.
            ring: Whose contact is estimated; the lowest where there is none of
                this number.

        Raises:
            ScenarioError: What has no compiled law.
        """
        rings = tuple(scenario.stages)
        self._ring = rings.index(ring) if ring in rings else 0
        self._name = f"ring{rings[self._ring]}"
        self._control = MakeControl(scenario, limits)
        self._plant = MakePlant(scenario, seed=None)
        self._band = band
        self.channels = reading_names(rings)
        period = scenario.control.rate**-1
        self._floor = _measure_floor(scenario, limits)
        self._mean = self._floor**2
        self._gain = low_pass_gain_tau(_AVERAGE, period)
        self._lag = low_pass_gain_tau(_REGRESSOR_LAG, period)
        self._period = period
        self._filtered = np.zeros(3)
        self._before = np.zeros(3)
        pads = self._plant.numbers.contact[self._ring]
        self.contact = ContactEstimate(
            pads[0:2], float(pads[5]), memory, period
        )
        self.ratio = np.ones(len(self.channels))
        self.alarms: list[str] = []
        self._readings = self._plant.advance(self._plant.hold).copy()
        self.readings = self._readings, self._readings
        self.signals: dict[str, tuple[float, float]] = {}
        self.difference = np.zeros(16 * len(rings) + 3)
        self.time = 0.0

    def Take(self, row: Row) -> None:
        """Takes a tick of the device, in order: readings, reference, pose."""
        twin = self._readings
        gap = row.readings - twin
        self._mean += self._gain * (gap**2 - self._mean)
        self.ratio = np.sqrt(self._mean) / self._floor
        self._Judge()
        command = self._control.Tick(twin, row.desired)
        self._Learn(row, twin)
        self._Keep(row, twin)
        virtual = row.y_virtual - self._control.y_virtual
        self.difference = np.concatenate([row.command - command, gap, virtual])
        self._readings = self._plant.advance(command).copy()

    def _Keep(self, row: Row, twin: np.ndarray) -> None:
        i, legs = self._ring, len(row.command)
        at = legs + 3 * i + 1
        places = row.y_ring[i], self._control.y_ring[i]
        forces = row.readings[at], twin[at]
        self.signals = {
            f"{self._name}_y_m": (float(places[0]), float(places[1])),
            f"{self._name}_force_y_N": (float(forces[0]), float(forces[1])),
        }
        self.readings = row.readings, twin
        self.time = row.tick * self._period

    def _Judge(self) -> None:
        """An alarm begins outside the band and ends well inside it."""
        for i in np.flatnonzero(self.ratio > self._band):
            if self.channels[i] not in self.alarms:
                self.alarms = [*self.alarms, self.channels[i]]
        for name in self.alarms:
            ratio = self.ratio[self.channels.index(name)]
            if ratio < 0.8 * self._band:
                self.alarms = [a for a in self.alarms if a != name]

    def _Learn(self, row: Row, twin: np.ndarray) -> None:
        i, marker = self._ring, len(twin) - 2
        mine = self._control.y_ring[i] - twin[marker]
        theirs = row.y_ring[i] - row.readings[marker]
        force = row.readings[len(row.command) + 3 * i + 1]
        raw = np.array([theirs, mine, force])
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
        ratios = zip(self.channels, self.ratio.tolist(), strict=True)
        return {
            "ratio": dict(ratios),
            "band": self._band,
            "alarms": self.alarms,
            "stiffness_N_m": float(k),
            "damping_N_s_m": float(c),
            "time_s": self.time,
            "signals": self.signals,
        }


def _measure_floor(scenario, limits: Limits) -> np.ndarray:
    """RMS of what noise does to each reading of the loop at rest (9 S + 3,).

    Readings feed the controller, so that noise comes back through the loop,
    to the upper rings of a stack more than to the lowest.
    """
    plant, control = (
        MakePlant(scenario, seed=_SEED),
        MakeControl(scenario, limits),
    )
    exact = MakePlant(scenario, seed=None)
    rest = exact.advance(exact.hold).copy()
    command, still, away = plant.hold, np.zeros((3, exact.num_stages)), []
    if exact.num_stages == 1:
        still = still[:, 0].copy()
    for _ in range(_SETTLE + _COUNT):
        readings = plant.advance(command).copy()
        command = control.Tick(readings, still)
        away.append(readings - rest)
    looped = np.sqrt(np.mean(np.square(away[_SETTLE:]), axis=0))
    numbers = plant.numbers
    # A marker that is not there now has its noise all the same.
    alone = np.hypot(
        numbers.noise_sigma, numbers.reading_steps / math.sqrt(12.0)
    )
    return np.maximum(looped, alone)
