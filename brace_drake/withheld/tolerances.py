"""Tolerances: how well the numbers of a real machine are known.

A machine is off its data sheet by a draw of each tolerance, whatever else is
wrong with it. What lies within is no finding; what a case is to be known by
lies `FAR` of them outside.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.withheld.simulator import TICK, Flaws, with_flaws

# What is wrong is off by at least so many tolerances.
FAR = 8.0
# A multiple of the tolerances above this makes no sensible machine.
LARGEST_FACTOR = 5.0


class ToleranceError(BraceError, ValueError):
    """A multiple of the tolerances is not a number, or out of range."""


class Tolerances(NamedTuple):
    """One standard deviation of each number; SI units."""

    ring_mass: float = 0.015  # kg
    leg_viscous: float = 1.5  # N s/m, one draw for all legs
    leg_friction: float = 0.03  # N, half of a normal one, for all legs
    anchor: float = 5e-5  # m, each coordinate of each of twelve anchors
    force_scale: float = 0.006  # of all three force readings
    force_bias: float = 0.02  # N, on the y reading
    delay: float = 0.5  # ticks, of a fair coin's 0 or 1


TOLERANCES = Tolerances()


@dataclass(frozen=True)
class Deviations:
    """How far one machine is off within its tolerances.

    Attributes:
        factor: Multiple of the tolerances that they were drawn with.
        added: By number of the simulator: what is added to it.
    """

    factor: float = 0.0
    added: dict[str, np.ndarray] = field(default_factory=dict)

    def on(self, flaws: Flaws) -> Flaws:
        """Flaws with the deviations added to what they are."""
        for name, more in self.added.items():
            part, number = name.split(".")
            old = np.asarray(getattr(getattr(flaws, part), number))
            flaws = with_flaws(flaws, {name: _plain(old + more)})
        return flaws

    def truth(self) -> dict[str, float]:
        """The deviations in the words of a label; of the anchors the spread."""
        off = self.added
        return {
            "leg_viscous_N_s_m": float(off["legs.viscous"]),
            "ring_mass_kg": float(off["ring.mass"]),
            "force_scale": float(off["sensors.scale"]),
            "force_bias_N": float(off["sensors.bias"]),
            "leg_dry_friction_N": float(off["legs.coulomb"]),
            "command_delay_s": float(off["legs.delay"]) * TICK,
            "anchor_spread_m": self.factor * TOLERANCES.anchor,
        }


def _plain(value: np.ndarray) -> object:
    return value if value.ndim else value.item()


def check_factor(factor: float) -> None:
    """Raises ToleranceError unless 0 <= factor <= LARGEST_FACTOR."""
    if not 0.0 <= factor <= LARGEST_FACTOR:
        raise ToleranceError(
            f"tolerances: {factor:g} is not a multiple from 0 to"
            f" {LARGEST_FACTOR:g}"
        )


def draw_deviations(rng: np.random.Generator, factor: float) -> Deviations:
    """Draws how far a machine is off; with a factor of 0 draws nothing."""
    if factor == 0.0:
        return Deviations()
    one = TOLERANCES

    def normal(deviation: float, *shape: int) -> np.ndarray:
        return np.asarray(factor * deviation * rng.standard_normal(shape))

    most = round(factor * 2.0 * one.delay)  # ticks
    return Deviations(
        factor,
        {
            "ring.mass": normal(one.ring_mass),
            "legs.viscous": normal(one.leg_viscous),
            "legs.coulomb": np.abs(normal(one.leg_friction)),
            "ring.lower": normal(one.anchor, 6, 3),
            "ring.upper": normal(one.anchor, 6, 3),
            "sensors.scale": normal(one.force_scale),
            "sensors.bias": normal(one.force_bias),
            "legs.delay": np.asarray(most * rng.integers(2)),
        },
    )
