"""The sizes that an axis counts in, and effects in them.

Laws of effects have lengths of their own, such as that of bristles. They are
those of a machine of reference, with travels of 10 mm and forces of 10 N. An
axis is simulated as if it were that machine: its own lengths and forces are a
number of times the reference's. Times stay what they are.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.recording.columns import AXIS, DEVICES, split_unit

# The machine of reference.
LENGTH_M, FORCE_N = 0.01, 10.0

_MOST_STARTS = 12
# What no name has in it.
_NO_NAME = str.maketrans("", "", "^)")
_FACTOR = re.compile(r"([A-Za-z]+)(?:\^?(-?\d))?")


@dataclass(frozen=True)
class AxisUnits:
    """How many times the machine of reference an axis is.

    Attributes:
        length: Of its lengths, or angles in rad.
        force: Of its forces, or torques in N m.
        is_rotary: Whether m stands for rad and N for N m.
        per_mass: Whether forces are accelerations, of a machine whose mass is
            not known.
    """

    length: float = 1.0
    force: float = 1.0
    is_rotary: bool = False
    per_mass: bool = False

    def scale(self, unit: str) -> float:
        """Value in SI of one unit of the machine of reference.

        Args:
            unit: SI, such as "N s/m"; units other than m, N and kg are left
                as they are.
        """
        above, _, below = unit.partition("/")
        return self._product(above) / self._product(below)

    def _product(self, units: str) -> float:
        sizes = {
            "m": self.length,
            "N": self.force,
            "kg": self.force / self.length,
        }
        return float(
            np.prod(
                [
                    sizes.get(name, 1.0) ** int(power or 1)
                    for name, power in _FACTOR.findall(units)
                ]
            )
        )

    def unit(self, unit: str) -> str:
        """A unit as this axis has it: "N m s/rad" for "N s/m" if rotary, "1/s"
        of an acceleration.
        """
        if self.per_mass:
            unit = _of_one_kg(unit)
        if not self.is_rotary:
            return unit
        words = {"m": "rad", "N": "N m", "kg": "kg m^2"}

        def turned(match: re.Match) -> str:
            name, power = match.groups()
            word = words.get(name, name)
            return f"{word}^{power}" if power else word

        return _FACTOR.sub(turned, unit)

    def name(self, name: str, unit: str) -> str:
        """A parameter's name, the unit at its end as this axis has it."""
        old, new = _suffix(unit), _suffix(self.unit(unit))
        return name.removesuffix(old) + new if name.endswith(old) else name

    def card(self, effect: Effect) -> Effect:
        """An effect with names, limits and starts for this axis."""
        return replace(
            effect,
            parameters=tuple(self._parameter(p) for p in effect.parameters),
        )

    def _parameter(self, parameter: EffectParameter) -> EffectParameter:
        scale = self.scale(parameter.unit)
        deviation = parameter.deviation
        return replace(
            parameter,
            name=self.name(parameter.name, parameter.unit),
            unit=self.unit(parameter.unit),
            lower=scale * parameter.lower,
            upper=scale * parameter.upper,
            starts=tuple(scale * s for s in parameter.starts),
            choices=tuple(scale * c for c in parameter.choices),
            off=None if parameter.off is None else scale * parameter.off,
            deviation=None if deviation is None else scale * deviation,
        )


def _of_one_kg(unit: str) -> str:
    """A unit with m/s^2 in the place of N and none in that of kg."""
    powers = {"m": 0, "s": 0, "1": 0}
    for sign, part in zip((1, -1), unit.partition("/")[::2], strict=True):
        for name, power in _FACTOR.findall(part):
            count = sign * int(power or 1)
            if name == "N":
                powers["m"] += count
                powers["s"] -= 2 * count
            elif name != "kg":
                powers[name] = powers.get(name, 0) + count

    def factors(sign: int) -> list[str]:
        found = {n: sign * p for n, p in powers.items() if sign * p > 0}
        return [n if p == 1 else f"{n}^{p}" for n, p in found.items()]

    above, below = " ".join(factors(1)) or "1", factors(-1)
    if len(below) > 1:
        return f"{above}/({' '.join(below)})"
    return "/".join([above, *below])


def input_unit(name: str) -> tuple[str, str]:
    """Quantity and unit of an extra input: of "input_pressure_bar" "pressure"
    and "bar".
    """
    own = name.removeprefix(DEVICES[AXIS].inputs)
    quantity, unit = split_unit(own)
    if not unit:
        quantity, _, unit = own.rpartition("_")
    return quantity or own, unit.replace("_", " ") or "1"


def _suffix(unit: str) -> str:
    """A unit as the end of a name: "N s/m" is "_N_s_m"."""
    return "_" + re.sub(r"[ /(]+", "_", unit).translate(_NO_NAME)


def with_few_starts(card: Effect) -> Effect:
    """A card whose parameters are searched from the first of their starts: for
    machines whose motion a replay has to find.
    """
    few = tuple(
        replace(p, starts=p.starts[:_MOST_STARTS]) for p in card.parameters
    )
    return replace(card, parameters=few)


def scales(effect: Effect, units: AxisUnits) -> np.ndarray:
    """Values in SI of one reference unit of each parameter of a card (n,)."""
    return np.array([units.scale(p.unit) for p in effect.parameters])
