"""Numbers with tolerances: how far each seems to be off beside a fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.devices.tolerances import sizes_off
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.effects.within_tolerances import ANCHORS, NUMBERS
from tools.baselines.case import Case

# Dry friction bends too much to be told by a straight line.
_BENT = "leg_dry_friction_N"
NUMBERS_TOLD = tuple(name for name in NUMBERS if name != _BENT)


class Tolerated:
    """The numbers of a case's device, told by columns of its signatures.

    A whitened column of one tolerance, times the whitened residual, is the
    estimate of the number beside its prior, with the other sign.

    Attributes:
        nuisances: The numbers (k,).
    """

    def __init__(self, case: Case):
        self._device = MakeDevice(case.campaign)
        known = {n.name: n for n in self._device.tolerances()}
        self.nuisances, columns, factors = [], [], []
        for name in NUMBERS_TOLD:
            key, number = NUMBERS[name].key, known[name]
            s = next(s for s in case.signatures if s.effect.key == key)
            self.nuisances.append(number)
            columns.append(s.first)
            factors.append(number.deviation / s.starts[0][0])
        (s,) = (s for s in case.signatures if s.effect.key == ANCHORS.key)
        self.nuisances += [known[name] for name in ANCHORS.parameter_names]
        columns += list(s.first + np.arange(s.size))
        factors += [1.0] * s.size
        self._columns, self._factors = np.array(columns), np.array(factors)

    def off(self, along: np.ndarray) -> np.ndarray:
        """Deviations (k,), from each column's product with a residual."""
        return -along[self._columns] * self._factors

    def uses(
        self, along: np.ndarray, effects: Sequence[Effect] = ()
    ) -> list[Use]:
        """Effects of the numbers where they seem to be, but of those that
        effects stand for.
        """
        pairs = zip(self.nuisances, self.off(along), strict=True)
        off = [
            0.0 if any(n.is_of(e) for e in effects) else max(t, n.lower)
            for n, t in pairs
        ]
        return list(self._device.uses_off(sizes_off(self.nuisances, off)))
