"""Rings, torso, legs and instruments, advanced tick by tick from outside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.laws.hooks import PLUG_POINTS
from brace_drake.laws.loop.brace_step import run_ticks
from brace_drake.laws.plug_in import PlugIn

# A jammed drive gives way so little, N/m and N s/m: as stiff as a tick can
# resolve with the ring's mass.
_JAM_STIFFNESS, _JAM_DAMPING = 5e4, 800.0
_NOISE_ROWS = 1000
# A leg's change that tells of a ring that has left its place, m: well above the
# noise, and less than what a supervisor takes for a jump.
_AWAY = 3e-4


@dataclass(frozen=True)
class PlantNumbers:
    """Arrays of a plant with S moving rings, bottom to top.

    Attributes:
        lower, upper: Anchors (S, 6, 3), m, see `laws.stages`.
        rest: Positions of the rings at rest (S, 3), m.
        start: q_WR, p_WR of the rings at time 0 (S, 7).
        torso_rest: Position of the torso at rest (3,), m.
        viscous: Of each leg (6 S,), N s/m.
        contact: Of each ring (S, 6), see `laws.blocks.calc_pad`.
        posture: (12,), as `laws.posture` takes it.
        rings, torso: Mass, moments (3), weight: (S, 5) and (5,).
        resolution: Of lengths, m, and forces, N (2,).
        noise_sigma: Of lengths (6 S), forces (3 S), marker (3).
    """

    lower: np.ndarray
    upper: np.ndarray
    rest: np.ndarray
    start: np.ndarray
    torso_rest: np.ndarray
    viscous: np.ndarray
    contact: np.ndarray
    posture: np.ndarray
    rings: np.ndarray
    torso: np.ndarray
    resolution: np.ndarray
    noise_sigma: np.ndarray


@dataclass(frozen=True)
class PlantTiming:
    """Ticks and steps.

    Attributes:
        period: Of a tick, s.
        steps: Of the plant in a tick.
    """

    period: float
    steps: int


class EmulatedPlant:
    """What a device moves and measures.

    Attributes:
        numbers: Its arrays, as effects have changed them.
        hold: Leg forces that carry the rings' weight, as the device knows
            them (6 S,), N.
        period: Of a tick, s.
        bodies: q, p of the rings and the torso, then [w; v] of each.
        u: Leg forces of the last tick (6 S,), N.
        jammed: Legs whose drives are jammed, from 0.
        frozen: Legs whose readings stand still, from 0.
    """

    def __init__(
        self,
        plant: PlantNumbers,
        timing: PlantTiming,
        hold: tuple[float, ...],
        plug_ins: Mapping[str, PlugIn],
        with_torso: bool,
        seed: int | None,
    ):
        """Builds a plant at rest.

        Args:
            plant: Its numbers.
            timing: Of its ticks.
            hold: See the attribute.
            plug_ins: Effects; on several stages each acts on all of them.
            with_torso: Whether the torso is there.
            seed: Of the instruments' noise; None: exact readings.
        """
        self.hold, self.period = hold, timing.period
        self.jammed: set[int] = set()
        self.frozen: set[int] = set()
        self.numbers, self._timing, self._plug_ins = plant, timing, plug_ins
        self._generator = None
        if seed is not None:
            self._generator = np.random.default_rng(seed)
        size = len(plant.noise_sigma)
        self._noise, self._row = np.zeros((0, size)), 0
        self._present = np.array([with_torso])
        self.reset()

    @property
    def num_stages(self) -> int:
        """S."""
        return len(self.numbers.rest)

    @property
    def with_torso(self) -> bool:
        """Whether the torso is there; a change puts all at rest."""
        return bool(self._present[0])

    @with_torso.setter
    def with_torso(self, value: bool) -> None:
        if value != self.with_torso:
            self._present[0] = value
            self.reset()

    @property
    def is_away(self) -> bool:
        """Whether the rings have left the place where they began."""
        if self._first_lengths is None:
            return False
        moved = np.abs(self._last_lengths - self._first_lengths)
        return bool(moved.max() > _AWAY)

    def put_rings_back(self) -> None:
        """Rings as at time 0; torso and effects stay as they are."""
        n = self.num_stages
        self.bodies[0 : 7 * n] = self.numbers.start.ravel()
        self.bodies[7 * n + 7 : 13 * n + 7] = 0.0

    def reset(self) -> None:
        """All bodies as at time 0, effects as before any motion."""
        plant, n = self.numbers, self.num_stages
        self.bodies = np.zeros(13 * n + 13)
        self.bodies[0 : 7 * n] = plant.start.ravel()
        self.bodies[7 * n] = 1.0
        self.bodies[7 * n + 4 : 7 * n + 7] = plant.torso_rest
        self.u, self._readings = np.array(self.hold), np.zeros(9 * n + 3)
        self._last_lengths = np.zeros(6 * n)
        self._first_lengths: np.ndarray | None = None
        self._jams: dict[int, float] = {}
        self._draw_noise = np.full(9 * n + 3, np.nan)
        self._viscous = plant.viscous.copy()
        plugs = [self._plug_ins[point] for point in PLUG_POINTS]
        self._ticks = run_ticks(
            self.period / self._timing.steps,
            self._timing.steps,
            self._present,
            (plant.lower, plant.upper),
            plant.rest,
            plant.contact,
            (plant.torso_rest, self._viscous, plant.posture, plant.resolution),
            (plant.rings, plant.torso),
            *(plug.laws for plug in plugs),
            plugs[0].parameters,
            *(_fresh_memory(plug, n) for plug in plugs),
            np.array([plug.active for plug in plugs]),
            self.bodies,
            self._draw_noise,
            self._readings,
            self.u,
        )

    def advance(self, u) -> np.ndarray:
        """Drives the legs with u (6 S,), N, for a tick, then reads.

        Returns:
            Readings: lengths (6 S), m, forces (3 S), N, marker (3), m. The
            first call after a reset only reads.

        Raises:
            BraceError: The bodies have flown apart.
        """
        self._draw()
        self.u[:] = u
        self._viscous[:] = self.numbers.viscous
        self._jams = {
            k: self._jams.get(k, self._last_lengths[k]) for k in self.jammed
        }
        for k, length in self._jams.items():
            self._viscous[k] = _JAM_DAMPING
            self.u[k] = _JAM_STIFFNESS * (length - self._last_lengths[k])
        next(self._ticks)
        if not np.abs(self.bodies[5 : 7 * self.num_stages + 7 : 7]).sum() < 1.0:
            raise BraceError("the emulated brace broke down")
        for k in self.frozen:
            self._readings[k] = self._last_lengths[k]
        self._last_lengths[:] = self._readings[: len(self._last_lengths)]
        if self._first_lengths is None:
            self._first_lengths = self._last_lengths.copy()
        if not self.with_torso:
            self._readings[-3:] = 0.0
        return self._readings

    def _draw(self) -> None:
        if self._generator is None:
            return
        if self._row == len(self._noise):
            shape = (_NOISE_ROWS, len(self._readings))
            draws = self._generator.standard_normal(shape)
            self._noise, self._row = draws * self.numbers.noise_sigma, 0
        self._draw_noise[:] = self._noise[self._row]
        self._row += 1


def _fresh_memory(plug: PlugIn, num_stages: int) -> tuple[np.ndarray, ...]:
    """Initial states of a point's effects, of each stage its own."""
    if plug.point == "torso":
        return plug.fresh_memory()
    return tuple(np.tile(x, num_stages) for x in plug.initial)
