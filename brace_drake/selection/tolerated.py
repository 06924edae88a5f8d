"""What is within tolerances, and so no finding, and what is not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.effects.stack import Use
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds


def strained(excess: float, stretch: float, count: int) -> float:
    """An excess, and what stretched tolerances cost where next to nothing is
    left beside them: the excess that would cost as much in a score.

    Args:
        excess: Sum of squares above noise.
        stretch: Of the numbers known to a tolerance.
        count: Number of independent values.
    """
    factor = max(1.0, stretch / thresholds.WITHIN) ** thresholds.TAIL
    return excess + thresholds.TRUST * count * (factor - 1.0)


def left_by(fit: CandidateFit, count: int) -> float:
    """What a fit leaves, strained."""
    return strained(fit.excess, fit.stretch, count)


def is_within(
    use: Use, spread: float | None, nuisances: Sequence[Nuisance]
) -> bool:
    """Whether an effect is a number that stays within its tolerance.

    Args:
        use: The effect with its fitted parameters.
        spread: Standard deviation of alike parameters, if it has such.
        nuisances: Numbers known to a tolerance.
    """
    effect, values = use
    numbers = [n for n in nuisances if n.is_of(effect)]
    if not numbers or effect.contains:
        return False
    deviations = [n.deviation for n in numbers]
    if effect.spread is not None:
        # The spread of so many draws is known to 1 / sqrt(2 n) of itself.
        known = 1.0 / np.sqrt(2.0 * effect.is_continuous.sum())
        most = (1.0 + thresholds.WITHIN * known) * max(deviations)
        return bool(spread <= most)
    strengths = np.abs(values[: len(effect.parameters)][effect.is_strength])
    size = strengths.max()
    if not any(e.name == effect.name for n in numbers for e, _ in n.uses):
        # A richer form of the number: what it adds to it counts as well.
        kinds = zip(effect.parameters, effect.is_strength, strict=True)
        units = {p.unit for p, is_strength in kinds if is_strength}
        size = strengths.sum() if units == {numbers[0].unit} else np.inf
    return bool(size <= thresholds.WITHIN * max(deviations))


def holds_another(use: Use, nuisances: Sequence[Nuisance]) -> bool:
    """Whether what an effect contains is beyond its tolerance: then it is an
    effect beside it, as dry friction is in a leg that gives way.

    Args:
        use: The effect with its fitted parameters.
        nuisances: Numbers known to a tolerance.
    """
    effect, values = use
    sizes = dict(zip(effect.parameter_names, np.abs(values), strict=False))
    return any(
        sizes.get(p.name, 0.0) > thresholds.WITHIN * number.deviation
        for number in nuisances
        for card, _ in number.uses
        if card.name in effect.contains
        for p in card.parameters
    )
