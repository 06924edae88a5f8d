"""The level: what even a right twin leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.replays import uses_in_run
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.held_out import estimate_off
from brace_drake.identification.prepare import noise_replicates
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion


def make_criterion(
    evaluator: Evaluator, nominal: CandidateFit, nuisances: Sequence[Nuisance]
) -> Criterion:
    """The criterion that a search sets out with."""
    criterion = Criterion(
        nominal,
        evaluator.count,
        evaluator.recorded,
        nuisances=tuple(nuisances),
    )
    return with_level(evaluator, criterion, nominal)


def with_level(
    evaluator: Evaluator, criterion: Criterion, fit: CandidateFit
) -> Criterion:
    """The criterion with the level that a fit adds to it."""
    chance = chance_of(evaluator, fit)
    level = level_of(evaluator, fit) + chance
    return replace(criterion, level=level, chance=chance)


def level_of(evaluator: Evaluator, fit: CandidateFit) -> float:
    """Misfit that even a right twin leaves, if a fit is it, beside chance.

    The noise's level, and where dry friction is in the fit or within its
    tolerance a part of what that does, as it is as inexact as its law.

    Args:
        evaluator: Over the fit runs.
        fit: Whose friction is taken.
    """
    power = tolerated_friction(evaluator, fit)
    rough = _rough(fit)
    if rough:
        (change,) = evaluator.changes(fit.subject, (), [rough])
        power += float(change @ change) / evaluator.count
    return thresholds.LEVEL + thresholds.TRUST**2 * power


def chance_of(evaluator: Evaluator, fit: CandidateFit) -> float:
    """Mean square that chance adds to the noise's: of two replays of a fit that
    differ in their noise alone, half of the square of their difference; none
    where no drives stick.

    Args:
        evaluator: Over the fit runs.
        fit: Whose friction is taken.
    """
    if not _rough(fit):
        return 0.0

    def square(run: PreparedRun) -> float:
        # Noise that the fit was replayed with: its twin stands it.
        noise = noise_replicates(
            evaluator.twin,
            run.motion,
            fit.subject,
            uses_in_run(fit.uses, run.index),
            [[run.seed, i] for i in range(2)],
        )
        return sum(float(x @ x) for x in map(run.weigh, noise))

    tasks = [(run,) for run in evaluator.prepared]
    squares = sum(evaluator.map(square, tasks))
    return max(0.0, 0.5 * squares / evaluator.count - 1.0)


def _rough(fit: CandidateFit) -> list[Use]:
    return [u for u in fit.uses if u[0].dithered]


def tolerated_friction(
    evaluator: Evaluator, fit: CandidateFit, most: float = thresholds.WITHIN
) -> float:
    """Mean square that dry friction changes, as far as a fit has it off.

    Args:
        evaluator: Over the fit runs.
        fit: Beside tolerances.
        most: Tolerances that it is off, at most.
    """
    if fit.tolerances is None:
        return 0.0
    off = estimate_off(evaluator, fit)
    rough = [t if n.is_dithered else 0.0 for n, t in off]
    within = np.clip(rough, -most, most)
    return fit.tolerances.change(within) / evaluator.count
