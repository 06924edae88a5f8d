"""The axis' scenario: any machine of one degree of freedom, by its numbers."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.recording.columns import AXIS
from brace_drake.recording.ways import axis_columns
from brace_drake.scenario.axis.cards import (
    BEHIND_MOTOR,
    COMMANDED,
    OwnCard,
    own_cards,
)
from brace_drake.scenario.axis.units import FORCE_N, LENGTH_M, AxisUnits
from brace_drake.scenario.brace import EffectUse
from brace_drake.scenario.fields import items, number, vector, word
from brace_drake.scenario.pad_noise import NOISE_EDGES_HZ

# Of the range of the force: what any twin is exact to.
_EXACT = 1e-3


@dataclass(slots=True)
class AxisScenario:
    """One axis: F = m a + b v + k y + F_0 + gains . extra inputs.

    A rotary axis has rad for m and N m for N in all numbers. Under a command of
    speed r it is y'' = u + i - b y' + bias, u = (r - y') / lag + f r', of
    position u = w^2 (r - y) + 2 z w (f r' - y'); i' = n u, or of position n
    times w^2 (r - y) + 2 z w (r' - y'), which is an integral of the error.
    Behind a motor whose position r was measured it is
    y'' = w^2 (r + offset - y) + 2 z w (r' - y') - b y'; its offset is a length.
    All of these are for 1 kg, b too.
    """

    device: str = AXIS
    kind: str = word("linear", "rotary")
    # What it is given: a motion that is imposed, whatever force was measured or
    # commanded, or a command that it follows, or the motion of its motor.
    command: str = word("motion", "force", "speed", "position", "motor")
    # What of its motion was recorded; a speed alone under a command of speed.
    answer: str = word("position", "speed")
    # Longest step of the effects' states.
    time_step: float = number(0.001, "s", above=0.0)
    mass: float = number(0.0, "kg", least=0.0)
    viscous: float = number(0.0, "N s/m", least=0.0)
    stiffness: float = number(0.0, "N/m", least=0.0)
    offset: float = number(0.0, "N")
    lag: float = number(0.05, "s", above=0.0)
    frequency: float = number(30.0, "rad/s", above=0.0)  # w
    damping_ratio: float = number(1.0, least=0.0)  # z
    # Rate n of the controller's integral, a speed controller's gain K_i / K_p;
    # 0 without. What it integrates: all that its loop asks for, as a cascade
    # does, or the error of position alone.
    integral: float = number(0.0, "1/s", least=0.0)
    integrates: str = word("loop", "error")
    feed_forward: float = number(0.0, least=0.0)  # f, of the command's rate
    # Whether a command stays as it is until the next sample, or goes on a
    # straight line to it, as the motion of a motor does.
    is_held: bool = True
    bias: float = number(0.0, "m/s^2")
    # Force for each unit of an extra input, by its column.
    gains: dict[str, float] = field(default_factory=dict)
    # Largest acceleration by what a joint behind a motor was wound up.
    wound: float = number(0.0, "m/s^2", least=0.0)
    # Numbers of the machine that every recording is fitted anew.
    fitted: list[str] = items("offset")
    # Standard deviation that a reading would have were its noise at all
    # frequencies as strong as from this one of NOISE_EDGES_HZ on.
    force_noise: np.ndarray = vector(
        *[0.0] * len(NOISE_EDGES_HZ), unit="N", least=0.0
    )
    # Standard deviation of a reading.
    position_noise: float = number(0.0, "m", least=0.0)
    # Sizes of motion, force and extra inputs, by which ranges of effects go.
    length_scale: float = number(0.01, "m", above=0.0)
    speed_scale: float = number(0.01, "m/s", above=0.0)
    acceleration_scale: float = number(0.01, "m/s^2", above=0.0)
    force_scale: float = number(10.0, "N", above=0.0)
    input_scales: dict[str, float] = field(default_factory=dict)
    effects: list[EffectUse] = items()

    @property
    def is_imposed(self) -> bool:
        """Whether its motion is put in, and a force answers."""
        return self.command in ("motion", "force")

    @property
    def units(self) -> AxisUnits:
        """What the axis counts in; its forces under a command for 1 kg."""
        length, is_rotary = self.length_scale / LENGTH_M, self.kind == "rotary"
        if not self.is_imposed:
            return AxisUnits(length, length, is_rotary, per_mass=True)
        return AxisUnits(length, self.force_scale / FORCE_N, is_rotary)

    @property
    def ranges(self) -> AxisUnits:
        """The same with the sizes that ranges of effects go by."""
        if self.is_imposed:
            return self.units
        # Behind a motor forces wind up a joint, however stiff it is.
        force = max(self.wound, self.acceleration_scale) / FORCE_N
        return replace(self.units, force=force)

    @property
    def force_doubt(self) -> float:
        """Deviation of a force reading; of readings without noise, of what any
        twin is exact to.
        """
        return max(float(np.max(self.force_noise)), _EXACT * self.force_scale)

    @property
    def most_mass(self) -> float:
        """A mass that would make all of the force by itself."""
        return self.force_scale / self.acceleration_scale

    @property
    def command_size(self) -> float:
        """Half of the range of a command of speed or position."""
        is_speed = self.command == "speed"
        return self.speed_scale if is_speed else self.length_scale

    def own_cards(self) -> dict[str, OwnCard]:
        """Effects that it can have, in its own units, by key."""
        sizes = tuple(self.input_scales.get(n, 1.0) for n in self.gains)
        position, moved_by = axis_columns(self.kind, self.command)
        device, column = AXIS if self.is_imposed else COMMANDED, moved_by
        if self.command == "motor":
            device, column = BEHIND_MOTOR, position
        signal = column, self.command_size
        inputs = tuple(self.gains)
        units = self.units, self.ranges
        return own_cards(device, *units, inputs, sizes, signal)

    def of_reference(self, uses: Sequence[Use]) -> list[Use]:
        """Effects with the parameters of the machine of reference."""
        cards = self.own_cards()
        return [(e, cards[e.key].of_reference(v)) for e, v in uses]

    def own_effects(self) -> dict[str, Effect]:
        """Cards of those, by key."""
        return {key: own.card for key, own in self.own_cards().items()}


@dataclass(frozen=True)
class AxisNumbers:
    """The scenario's numbers as the laws take them, SI.

    Attributes:
        law: Mass, viscous, stiffness, offset, then the gains (4 + J,).
        force_noise: In the bands of NOISE_EDGES_HZ (B,), N.
        position_noise: (1,), m.
    """

    law: np.ndarray
    force_noise: np.ndarray
    position_noise: np.ndarray

    def with_changes(self, **arrays: np.ndarray) -> "AxisNumbers":
        """A copy with some arrays replaced."""
        return replace(self, **arrays)


def pack_axis(scenario: AxisScenario) -> "AxisNumbers":
    """Arrays of the nominal twin that a scenario describes."""
    named = (
        scenario.mass,
        scenario.viscous,
        scenario.stiffness,
        scenario.offset,
    )
    return AxisNumbers(
        law=np.array([*named, *scenario.gains.values()], dtype=float),
        force_noise=np.array(scenario.force_noise, dtype=float),
        position_noise=np.array([scenario.position_noise]),
    )
