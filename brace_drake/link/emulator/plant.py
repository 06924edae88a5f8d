"""Rings, torso, legs and instruments, advanced tick by tick from outside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.core.errors import BraceError, EffectError
from brace_drake.effects.stack import Use, modify_numbers, stack_effects
from brace_drake.kinematics import holding_leg_forces
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.ticks import run_ticks
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import make_effects
from brace_drake.laws.stages import place_rings
from brace_drake.scenario.brace_numbers import geometry_of

# A jammed drive gives way so little, N/m and N s/m: as stiff as a tick can
# resolve with the ring's mass.
_JAM_STIFFNESS, _JAM_DAMPING = 5e4, 800.0
_NOISE_ROWS = 1000
# A leg's change that tells of a ring that has left its place, m: well above the
# noise, and less than what a supervisor takes for a jump.
_AWAY = 3e-4


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
        numbers: BraceNumbers,
        time_step: float,
        uses: Sequence[Use],
        with_torso: bool,
        seed: int | None,
    ):
        """Builds a plant at its start.

        Args:
            numbers: As the device knows them.
            time_step: Of the plant, s.
            uses: Effects with their parameter vectors; each acts on every
                stage alike, once on the torso.
            with_torso: Whether the torso is there.
            seed: Of the instruments' noise; None: exact readings.
        """
        held = holding_leg_forces(geometry_of(numbers), numbers.ring[:, 4])
        self.hold, self.period = tuple(held.tolist()), numbers.period
        self.jammed: set[int] = set()
        self.frozen: set[int] = set()
        self._known, self._uses = numbers, tuple(uses)
        self.numbers = modify_numbers(numbers, uses)
        self._plug_ins = stack_effects(uses, self.numbers)
        self._steps = round(self.period / time_step)
        self._generator = None
        if seed is not None:
            self._generator = np.random.default_rng(seed)
        size = len(numbers.noise_sigma)
        self._noise, self._row = np.zeros((0, size)), 0
        self._with_torso = with_torso
        self.reset()

    @property
    def num_stages(self) -> int:
        """S."""
        return len(self.numbers.rest)

    @property
    def with_torso(self) -> bool:
        """Whether the torso is there; a change puts all at rest."""
        return self._with_torso

    @with_torso.setter
    def with_torso(self, value: bool) -> None:
        if value != self.with_torso:
            self._with_torso = value
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
        poses, V = self._brace.poses[:-1], self._brace.V[:-1]
        place_rings(self.numbers.start, self.numbers.rest, poses)
        V[:] = 0.0

    def reset(self) -> None:
        """All bodies as at time 0, effects as before any motion."""
        n = self.num_stages
        self._brace = brace = make_brace(self.numbers, self._with_torso)
        self.bodies, self.u, self._readings = (
            brace.bodies,
            brace.u,
            brace.readings,
        )
        self.u[:] = self.hold
        self._last_lengths = np.zeros(6 * n)
        self._first_lengths: np.ndarray | None = None
        self._jams: dict[int, float] = {}
        self._draw_noise = np.full(9 * n + 3, np.nan)
        self._Go()

    def _Go(self) -> None:
        """Lets time begin, wherever the bodies are."""
        self._viscous = self.numbers.viscous.copy()
        self._ticks = run_ticks(
            self.period / self._steps,
            self._steps,
            self.numbers.with_changes(viscous=self._viscous),
            make_effects(self._plug_ins, self.num_stages),
            self._brace,
            self._draw_noise,
        )

    def check_room(self, more: int) -> None:
        """Refuses more effects than a plant carries.

        Raises:
            EffectError: There would be more.
        """
        if len(self._uses) + more > MAX_EFFECTS:
            raise EffectError(
                f"the plant carries at most {MAX_EFFECTS} effects"
            )

    def begin_effects(self, uses: Sequence[Use]) -> None:
        """Further effects from now on, while all moves; those that were there
        begin anew.

        Raises:
            EffectError: More effects than a plant carries.
        """
        together = (*self._uses, *uses)
        numbers = modify_numbers(self._known, together)
        self._plug_ins = stack_effects(together, numbers)
        self._uses, self.numbers = together, numbers
        if self._first_lengths is None:
            self.reset()
            return
        self._Go()
        # The first tick only reads, where all is: this one was read before.
        self._draw_noise[:] = np.nan
        next(self._ticks)

    def WarmUp(self) -> None:
        """Loads laws, which the first host could not wait for; all at rest."""
        self.advance(self.hold)
        self.reset()
        # The same draws again: a recording does not tell.
        self._row = 0

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
        if not next(self._ticks):
            raise BraceError("the emulated brace broke down")
        for k in self.frozen:
            self._readings[k] = self._last_lengths[k]
        self._last_lengths[:] = self._readings[: len(self._last_lengths)]
        if self._first_lengths is None:
            self._first_lengths = self._last_lengths.copy()
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
