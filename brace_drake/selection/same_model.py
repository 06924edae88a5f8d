"""Rivals that are the same model: a richer law with nothing of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.identification.fits import CandidateFit

# Of its typical size, or of the strength beside it: what is nothing.
_NOTHING = 0.01


def simpler_twin(
    fit: CandidateFit, others: Sequence[CandidateFit]
) -> CandidateFit | None:
    """The fit of a special case that a fit has come down to; None without.

    Dry friction with a breakaway force of 0 is Coulomb friction: both say the
    same, and are no two explanations.

    Args:
        fit: Of any effects.
        others: Of the same search.
    """
    if not fit.is_searched:
        return None
    for other in others:
        if other.is_searched and comes_down_to(fit.uses, other.uses):
            return other
    return None


def comes_down_to(richer: Sequence[Use], simpler: Sequence[Use]) -> bool:
    """Whether both have the same effects, save special cases of some."""
    left = {e.key: e for e, _ in simpler}
    if len(richer) != len(left):
        return False
    is_richer = False
    for effect, values in richer:
        if left.pop(effect.key, None) is not None:
            continue
        case = next(
            (e for e in left.values() if effect.is_richer_than(e)), None
        )
        if case is None or not _adds_nothing(effect, values, case):
            return False
        del left[case.key]
        is_richer = True
    return is_richer


def _adds_nothing(effect: Effect, values: np.ndarray, case: Effect) -> bool:
    """Whether every strength that the special case has not is nothing."""
    pairs = zip(effect.parameters, np.abs(values), strict=False)
    own, shared = [], []
    for p, size in pairs:
        if p.off == 0.0:
            is_shared = p.name in case.parameter_names
            (shared if is_shared else own).append((p, size))
    return bool(own) and all(
        size
        <= _NOTHING
        * max([p.typical, *(s for q, s in shared if q.unit == p.unit)])
        for p, size in own
    )
