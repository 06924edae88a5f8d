"""Signatures: what each effect, at each of its starts, changes of a residual.

One replay each at the nominal fit, whitened as the residual is. Most effects
are one column, their strength times the start. Those of several alike numbers
have a column for each: the anchors' are those of their tolerances, the
encoders' one for each leg. A breath has a phase of its own in every run, so a
column in and one out of phase for each run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator

# An effect of more strengths than these has a column for each.
_FEW = 3


@dataclass(frozen=True)
class Signature:
    """One effect at one start.

    Attributes:
        effect: Its card.
        starts: Values that each column stands for, None where the columns
            are single runs'.
        first, size: Place of its columns among all.
    """

    effect: Effect
    starts: tuple[tuple[float, ...], ...] | None
    first: int
    size: int

    @property
    def has_one_sign(self) -> bool:
        """Whether its strength cannot be negative."""
        return self.size == 1 and not self.effect.has_either_sign

    @property
    def num_free(self) -> int:
        """Numbers that it takes: its columns, and a choice or shape."""
        return self.size + int(len(self.effect.starts()) > 1)

    def use(self, strengths: np.ndarray) -> Use | None:
        """The effect with strengths of its columns (size,), within limits."""
        if self.starts is None:
            return None
        card, start = self.effect, np.array(self.starts)
        moved = strengths @ start
        values = np.where(card.is_strength, moved, start[0])
        return card, np.clip(values, card.lower, card.upper)

    def row(self) -> list:
        """As it is kept."""
        return [self.effect.key, self.starts, self.first, self.size]

    @classmethod
    def read(cls, row: Sequence) -> Signature:
        """The one that was kept."""
        key, starts, first, size = row
        told = None if starts is None else tuple(map(tuple, starts))
        return cls(find_effect(key), told, first, size)


def calc_signatures(
    evaluator: Evaluator,
    subject: np.ndarray,
    tolerances: LinearTolerances | None,
) -> tuple[np.ndarray, list[Signature]]:
    """Columns of all effects (rows, n), whitened, and what they stand for."""
    blocks, found, at = [], [], 0

    def add(effect, starts, columns):
        nonlocal at
        columns = np.reshape(columns, (evaluator.ends[-1], -1))
        blocks.append(columns.astype(np.float32))
        found.append(Signature(effect, starts, at, columns.shape[1]))
        at += columns.shape[1]

    def whiten(columns):
        return columns if tolerances is None else tolerances.whiten(columns)

    asked = [use for effect in evaluator.effects for use in _starts(effect)]
    changes = _changes(evaluator, subject, [[use] for use in asked])
    for (effect, values), change in zip(asked, changes, strict=True):
        if change is not None and np.any(change):
            add(effect, (tuple(map(float, values)),), whiten(change))
    for effect in evaluator.effects:
        if effect.run_parameters:
            for pair in _breaths(evaluator, subject, effect):
                add(effect, None, whiten(pair))
        elif _has_alike(effect):
            columns, starts = _alike(evaluator, subject, effect, tolerances)
            add(effect, starts, whiten(columns))
    return np.column_stack(blocks), found


def _starts(effect: Effect) -> list[Use]:
    """Uses that are one column each."""
    if effect.run_parameters or _has_alike(effect):
        return []
    return [(effect, values) for values in effect.starts()]


def _has_alike(effect: Effect) -> bool:
    """Whether an effect is many numbers alike, one for each leg or anchor."""
    many = len(effect.parameters) > _FEW and bool(effect.is_strength.all())
    return effect.spread is not None or many


def _alike(
    evaluator: Evaluator,
    subject: np.ndarray,
    effect: Effect,
    tolerances: LinearTolerances | None,
) -> tuple[np.ndarray, tuple]:
    """A column for each of many alike numbers; those with tolerances have been
    replayed for them.
    """
    numbers = tolerances.nuisances if tolerances else ()
    known = [i for i, n in enumerate(numbers) if n.is_of(effect)]
    if known:
        starts = [numbers[i].uses[0][1] for i in known]
        columns = tolerances.basis @ tolerances.columns[:, known]
        return columns, tuple(tuple(map(float, v)) for v in starts)
    sizes = [p.typical for p in effect.parameters]
    starts = np.diag(np.minimum(sizes, 1e-4))
    points = [(subject, [(effect, v)]) for v in starts]
    (base,) = evaluator.weighted_residuals([(subject, ())], "coarse")
    there = evaluator.weighted_residuals(points, "coarse")
    kept = [i for i, x in enumerate(there) if x is not None]
    columns = np.column_stack([there[i] - base for i in kept])
    return columns, tuple(tuple(map(float, starts[i])) for i in kept)


def _breaths(
    evaluator: Evaluator, subject: np.ndarray, effect: Effect
) -> list[np.ndarray]:
    """For each start the columns of single runs, in and out of phase."""
    # The phase is the first of a run's own; of the others none is moved.
    own = np.zeros(len(effect.run_parameters))
    ends, runs = evaluator.ends, len(evaluator.prepared)
    pieces = list(zip([0, *ends], ends, strict=False))
    found = []
    for start in effect.starts():
        asked = [
            [(effect, np.append(start, np.tile(own + at, runs)))]
            for at in np.outer((0.0, np.pi / 2.0), np.eye(len(own))[0])
        ]
        changes = _changes(evaluator, subject, asked)
        columns = []
        for change in changes:
            for begin, end in pieces if change is not None else ():
                if np.any(change[begin:end]):
                    column = np.zeros_like(change)
                    column[begin:end] = change[begin:end]
                    columns.append(column)
        if columns:
            found.append(np.column_stack(columns))
    return found


def _changes(
    evaluator: Evaluator, subject: np.ndarray, more: list[list[Use]]
) -> list[np.ndarray | None]:
    """Changes of the weighted residual; None where the twin breaks down."""
    try:
        return list(evaluator.changes(subject, (), more))
    except BraceError:
        if len(more) == 1:
            return [None]
    half = len(more) // 2
    parts = more[:half], more[half:]
    return [c for part in parts for c in _changes(evaluator, subject, part)]
