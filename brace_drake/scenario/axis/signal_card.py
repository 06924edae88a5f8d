"""Effects on a signal, in the signal's own unit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.recording.columns import shown_unit, split_unit


def signal_card(
    effect: Effect, column: str, size: float
) -> tuple[Effect, np.ndarray]:
    """A card in the unit of a column, and the value of one unit of reference
    of each of its parameters there (n,).

    Args:
        effect: At the plug point `signal`.
        column: That it acts on.
        size: Half of the range that the column goes through.
    """
    unit = split_unit(column)[1]
    sizes = [size if "signal" in p.unit else 1.0 for p in effect.parameters]
    own = tuple(
        _scaled(p, s, unit)
        for p, s in zip(effect.parameters, sizes, strict=True)
    )
    return replace(effect, parameters=own), np.array(sizes)


def ramp_card(limit: Effect, card: Effect) -> Effect:
    """A limit of a command's rate as a form of what it limits of the motion.

    A drive that makes a ramp of its command, and follows that, limits the
    acceleration before its loop, and not in it.

    Args:
        limit: The limit of acceleration, or of speed, in the axis' units.
        card: The limit of the command's rate, in the command's unit.
    """
    (known,), (own,) = limit.parameters, card.parameters
    return replace(
        card,
        name=limit.name,
        title=f"{limit.title} of a ramp that the drive makes of its command",
        parameters=(replace(own, name=known.name, unit=known.unit),),
        signature=limit.signature,
        impostors=limit.impostors,
        experiment=limit.experiment,
        remedy=limit.remedy,
    )


def _scaled(
    parameter: EffectParameter, size: float, unit: str
) -> EffectParameter:
    """A parameter that is counted in a signal's size, in the signal's unit."""
    if "signal" not in parameter.unit:
        return parameter
    per_s = parameter.unit.endswith("/s")
    name = f"{parameter.name}_{unit}" if unit else parameter.name
    off = parameter.off
    return replace(
        parameter,
        name=name + "_s" * per_s,
        unit=(shown_unit(unit) or "1") + "/s" * per_s,
        lower=size * parameter.lower,
        upper=size * parameter.upper,
        starts=tuple(size * s for s in parameter.starts),
        off=None if off is None else size * off,
    )
