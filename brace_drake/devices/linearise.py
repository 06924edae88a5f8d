"""Tolerances linearised: each number is put off in turn, and all runs replayed.

See `devices.tolerances` for what is made of the differences.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import qr

from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import (
    LinearTolerances,
    UsesOff,
    able_off,
    uses_within,
)
from brace_drake.effects.stack import Use, behind_joints

# Mean square, in floors, that a direction of one deviation changes at least.
_TELLS = 0.1

# Where drives stick and slip by chance, columns are differenced over so many
# deviations: how the chance falls is part of every difference.
_FAR = 3.0
# Rows of a matrix that are worked on at once.
_BLOCK = 4096


def linearise_tolerances(
    evaluator,
    nuisances: Sequence[Nuisance],
    subject: np.ndarray,
    uses: Sequence[Use] = (),
    uses_off: UsesOff | None = None,
    off: np.ndarray | None = None,
    before: LinearTolerances | None = None,
    noise: float = 1.0,
) -> LinearTolerances | None:
    """The change of all runs by each number, at a subject and with effects.

    None where no number has a tolerance, or the twin breaks down.

    Args:
        evaluator: Over the runs.
        nuisances: Numbers with a tolerance.
        subject: Values of the subject's parameters.
        uses: Effects that are there.
        uses_off: Effects of numbers that are off.
        off: Deviations of each to linearise at (n,); needs `uses_off`.
        before: Linearised nearby; what told next to nothing there is taken
            from it.
        noise: Variance of all else along the numbers.
    """
    if not nuisances:
        return None
    if off is not None:
        off = able_off(nuisances, off)
    here = uses_within(nuisances, off, uses_off)
    ways = np.eye(len(nuisances))
    if before is not None and off is not None:
        ways = _telling_ways(before, evaluator.count)
    is_rough = any(e.dithered for e, _ in uses)
    after, steps = [], []
    for way in ways:
        (places,) = np.nonzero(way)
        one = nuisances[places[0]]
        # Dry friction, and numbers without effects where they are off.
        alone = len(places) == 1 and (one.is_dithered or off is None)
        step = _FAR if is_rough and not one.is_dithered else 1.0
        after.append(
            _with_number(evaluator, (*uses, *here), one, step)
            if alone
            else (*uses, *uses_within(nuisances, off + step * way, uses_off))
        )
        steps.append(step)
    try:
        changes = evaluator.changes(subject, (*uses, *here), after)
    except BraceError:
        return None
    # A column takes megabytes: none stands twice for long.
    columns = np.empty((len(changes[0]), len(nuisances)), order="F")
    while changes:
        last = len(changes) - 1
        np.divide(changes.pop(), steps[last], out=columns[:, last])
    if len(ways) < len(nuisances):
        other = before.columns @ (np.eye(len(nuisances)) - ways.T @ ways)
        for i in range(0, len(columns), _BLOCK):
            rows = slice(i, i + _BLOCK)
            told = columns[rows, : len(ways)] @ ways
            columns[rows] = told + before.basis[rows] @ other
    basis, coefficients = qr(
        columns, overwrite_a=True, mode="economic", check_finite=False
    )
    return LinearTolerances(
        tuple(nuisances), basis, coefficients, uses_off, off, noise=noise
    )


def _with_number(
    evaluator, uses: Sequence[Use], number: Nuisance, step: float
) -> tuple[Use, ...]:
    """Effects, and a number off by so many deviations where it acts."""
    for card, values in number.uses:
        held = behind_joints(uses, card, values * step, evaluator.effects)
        uses = held[0] if held else (*uses, (card, values * step))
    return tuple(uses)


def _telling_ways(before: LinearTolerances, count: int) -> np.ndarray:
    """Orthonormal directions of the numbers that tell (m, n): of those that
    make a straight line the ones that change enough, and each of the others.
    """
    rough = np.array([n.is_dithered for n in before.nuisances])
    smooth = np.where(rough, 0.0, before.columns)
    _, sizes, ways = np.linalg.svd(smooth)
    ways = ways[: len(sizes)][sizes**2 > _TELLS * count]
    return np.vstack([ways, np.eye(len(rough))[rough]])
