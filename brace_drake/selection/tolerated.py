"""What is within tolerances: effects that are no finding, and the level that
the laws of dry friction add to what a right twin leaves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion


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
    deviations = [n.deviation for n in nuisances if _is_of(n, effect)]
    if not deviations:
        return False
    if effect.spread is not None:
        return bool(spread <= thresholds.WITHIN * max(deviations))
    strengths = np.abs(values[: len(effect.parameters)][effect.is_strength])
    return bool(strengths.max() <= thresholds.WITHIN * max(deviations))


def _is_of(nuisance: Nuisance, effect: Effect) -> bool:
    names = {e.name for e, _ in nuisance.uses}
    return bool(names & {effect.name, *effect.generalises})


def uses_within(
    fit: CandidateFit, nuisances: Sequence[Nuisance]
) -> tuple[Use, ...]:
    """A fit's effects that are within their tolerances."""
    return tuple(u for u in fit.uses if is_within(u, fit.spread, nuisances))


def level_of(
    evaluator: Evaluator, fit: CandidateFit, nuisances: Sequence[Nuisance]
) -> float:
    """Misfit that even a right twin leaves, if a fit is it.

    The noise's level, and a part of what dry friction within its tolerance
    does, which is as inexact as its law.

    Args:
        evaluator: Over the fit runs.
        fit: Whose friction is taken.
        nuisances: Numbers known to a tolerance.
    """
    rough = [u for u in uses_within(fit, nuisances) if u[0].dithered]
    power = 0.0
    if rough:
        changes = evaluator.map(
            lambda p: evaluator.change(
                p, fit.subject, (), rough, evaluator.twin.coarse()
            ),
            [(p,) for p in evaluator.prepared],
        )
        power = sum(float(c @ c) for c in changes) / evaluator.count
    known = evaluator.tolerances
    if known is not None:
        residual = fit.solution.residual[: evaluator.ends[-1]]
        off = known.estimate(
            residual, 1.0 + max(0.0, fit.excess) / evaluator.count
        )
        is_rough = [n.uses[0][0].dithered for n in known.nuisances]
        change = known.sizes * (known.right @ np.where(is_rough, off, 0.0))
        power += float(change @ change) / evaluator.count
    return thresholds.LEVEL + thresholds.FRICTION_ERROR**2 * power


def make_criterion(
    evaluator: Evaluator, nominal: CandidateFit, nuisances: Sequence[Nuisance]
) -> Criterion:
    """The criterion that a search sets out with."""
    return Criterion(
        nominal,
        evaluator.count,
        evaluator.recorded,
        level_of(evaluator, nominal, nuisances),
    )
