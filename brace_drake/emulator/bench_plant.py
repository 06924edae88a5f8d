"""The bench of a scenario, advanced tick by tick by whoever commands it."""

from __future__ import annotations

import numpy as np

from brace_drake.effects.stack import Use, modify_numbers, stack_effects
from brace_drake.errors import BraceError
from brace_drake.laws.bench_step import run_ticks
from brace_drake.laws.hooks import PLUG_POINTS
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.bench_numbers import hold_forces, pack_bench
from brace_drake.scenario.effects import scenario_uses
from brace_drake.twin.bench_rollout import rest_state
from brace_drake.twin.subject import with_subject

# A jammed drive gives way so little, N/m and N s/m: as stiff as a tick can
# resolve with the ring's mass.
_JAM_STIFFNESS, _JAM_DAMPING = 5e4, 800.0


class BenchPlant:
    """Ring, torso, legs and instruments of one bench.

    Attributes:
        numbers: Of the plant, as effects have changed them.
        period: Of a tick, s.
        hold: Leg forces that carry the ring's weight, as the device knows it.
        jammed: Legs whose drives are jammed, from 0.
        frozen: Legs whose readings stand still, from 0.
    """

    def __init__(
        self,
        scenario: BenchScenario,
        uses: tuple[Use, ...] = (),
        subject: np.ndarray | None = None,
        seed: int | None = 0,
    ):
        numbers = pack_bench(scenario)
        if subject is not None:
            numbers = with_subject(numbers, subject)
        self.hold = hold_forces(numbers)
        uses = (*scenario_uses(scenario), *uses)
        self.numbers = modify_numbers(numbers, uses)
        self.period = 1.0 / scenario.control.rate
        self.jammed: set[int] = set()
        self.frozen: set[int] = set()
        self._steps = round(self.period / scenario.time_step)
        self._plugs = stack_effects(uses, self.numbers)
        self._generator = None
        if seed is not None:
            self._generator = np.random.default_rng(seed)
        self._noise, self._row = np.zeros((0, 12)), 0
        self._present = np.array([scenario.torso.present])
        self.reset()

    @property
    def with_torso(self) -> bool:
        """Whether the torso is there; a change puts the bench at rest."""
        return bool(self._present[0])

    @with_torso.setter
    def with_torso(self, value: bool) -> None:
        if value != self.with_torso:
            self._present[0] = value
            self.reset()

    def reset(self) -> None:
        """Both bodies at rest, time 0, effects as before any motion."""
        numbers = self.numbers
        self.bodies = rest_state(numbers.rest)
        self.u, self._readings = np.array(self.hold), np.zeros(12)
        self._last_lengths = np.zeros(6)
        self._jams: dict[int, float] = {}
        self._draw_noise = np.full(12, np.nan)
        self._viscous = numbers.viscous.copy()
        plugs = [self._plugs[point] for point in PLUG_POINTS]
        self._ticks = run_ticks(
            self.period / self._steps,
            self._steps,
            self._present,
            (numbers.p_WB, numbers.p_RT),
            (
                numbers.rest,
                self._viscous,
                numbers.contact,
                numbers.posture,
                numbers.resolution,
            ),
            (numbers.ring, numbers.torso),
            *(plug.laws for plug in plugs),
            plugs[0].parameters,
            *(plug.fresh_memory() for plug in plugs),
            np.array([plug.active for plug in plugs]),
            self.bodies,
            self._draw_noise,
            self._readings,
            self.u,
        )

    def advance(self, u) -> np.ndarray:
        """Drives the legs with u (6,), N, for a tick, then reads.

        Returns:
            Readings: lengths (6), m, force (3), N, marker (3), m. The first
            call after a reset only reads.

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
        if not abs(self.bodies[5]) + abs(self.bodies[12]) < 1.0:
            raise BraceError("the emulated bench broke down")
        for k in self.frozen:
            self._readings[k] = self._last_lengths[k]
        self._last_lengths[:] = self._readings[0:6]
        if not self.with_torso:
            self._readings[9:12] = 0.0
        return self._readings

    def _draw(self) -> None:
        if self._generator is None:
            return
        if self._row == len(self._noise):
            draws = self._generator.standard_normal((1000, 12))
            self._noise, self._row = draws * self.numbers.noise_sigma, 0
        self._draw_noise[:] = self._noise[self._row]
        self._row += 1
