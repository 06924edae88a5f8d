"""The ranked causes of a diagnosis as rows of its document."""

from __future__ import annotations

import numpy as np

from brace_drake.diagnose import Diagnosis
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import effects_for
from brace_drake.identification.intervals import (
    EstimateTable,
    ParameterEstimate,
)
from brace_drake.isolation.block_tests import holds_at_rest
from brace_drake.selection.surrogate_data import surrogate_gains
from brace_drake.validation.held_out import held_out_misfit


def cause_rows(d: Diagnosis) -> list[dict]:
    """Every candidate with its parameters and the decision: the winner, then
    by what they leave on motions that they have not seen; then pairs of which
    one effect does as well, then who was not searched.
    """
    rows = []
    winner = d.verdict.winner
    left = [held_out_misfit(d.evaluator, f) for f in d.fits]
    ranked = sorted(
        zip(d.fits, left, strict=True), key=lambda row: _rank(d, *row)
    )
    for fit, held_out in ranked:
        is_winner = fit is winner
        estimates = d.table if is_winner else None
        rows.append(
            {
                "effect": fit.name,
                "chosen": is_winner,
                "block": "+".join(dict.fromkeys(e.block for e in fit.effects)),
                "title": " and ".join(e.title for e in fit.effects),
                "excess": d.criterion.misfit(fit),
                "held_out": held_out,
                "decoys": _decoys(d, fit),
                "explained": max(
                    0.0,
                    d.criterion.closed(fit),
                ),
                "validation": _validation(d, fit),
                "searched": fit.is_searched,
                "converged": fit.refined,
                "identifiable": not _is_tied(d, fit),
                "decision": _decision(d, fit, is_winner),
                "parameters": effect_parameters(fit, estimates),
            }
        )
    return rows + [_absent_row(d, card) for card in _absent(d)]


def _rank(d: Diagnosis, fit, held_out: float | None):
    left = d.criterion.misfit(fit) if held_out is None else held_out
    return (
        fit is not d.verdict.winner,
        not fit.is_searched,
        _part_as_good(d, fit) is not None,
        left,
    )


def _part_as_good(d: Diagnosis, fit):
    if fit is d.verdict.winner:
        return None
    return d.criterion.part_as_good(fit, d.fits)


def _absent(d: Diagnosis) -> list[Effect]:
    """Effects that were not tried as there is nothing of them at rest."""
    if not (d.verdict.gap and holds_at_rest(d.ladder)):
        return []
    tried = {e.name for fit in d.fits for e in fit.effects}
    cards = effects_for(d.evaluator.twin.device).values()
    return [c for c in cards if c.at_rest and c.name not in tried]


def _absent_row(d: Diagnosis, card: Effect) -> dict:
    return {
        "effect": card.name,
        "chosen": False,
        "block": card.block,
        "title": card.title,
        "excess": d.criterion.misfit(d.nominal),
        "held_out": None,
        "decoys": None,
        "explained": 0.0,
        "validation": None,
        "searched": False,
        "converged": False,
        "identifiable": True,
        "decision": "nothing of it in the leg lengths at rest",
        "parameters": [],
    }


def _validation(d: Diagnosis, fit) -> dict | None:
    """What it leaves on runs that it has not seen; None where not replayed."""
    for prediction in d.predictions:
        if prediction.fit is fit:
            low, high = prediction.interval
            return {"gap": prediction.gap, "lower95": low, "upper95": high}
    return None


def _decoys(d: Diagnosis, fit) -> dict | None:
    """Squares of the gap that it takes, and that the best of its decoys does;
    None where it was not compared in earnest.
    """
    there = d.criterion.misfit(d.nominal)
    compared = [d.verdict.winner, *(p.fit for p in d.predictions)]
    if there <= 0.0 or all(fit is not other for other in compared):
        return None
    gains = surrogate_gains(d.evaluator, d.nominal, fit, d.seed)
    if gains.size == 0:
        return None
    return {
        "number": len(gains),
        "taken": d.criterion.gain(fit, d.nominal) / there,
        "best_decoy": float(gains[-1]) / there,
    }


def _is_tied(d: Diagnosis, fit) -> bool:
    return "+".join(fit.identifiers) in d.verdict.ambiguous_with


def _decision(d: Diagnosis, fit, is_winner: bool) -> str:
    if is_winner:
        return "explains the gap"
    if not d.verdict.gap:
        return "no gap to explain"
    if _is_tied(d, fit):
        return "as good as the first on these data"
    part = _part_as_good(d, fit)
    if part is not None:
        return f"leaves as much as {part.name} alone"
    if not d.criterion.gains(fit, d.nominal):
        return "gains no more than noise would"
    if not fit.is_scattered:
        return "its many parameters do not look like a draw"
    rest = 1.0 + max(0.0, d.criterion.misfit(fit))
    return f"leaves {np.sqrt(rest):.1f} times the floor on the fit runs"


def effect_parameters(fit, table: EstimateTable | None) -> list[dict]:
    """Fitted parameters of a candidate; with intervals where `table` is.

    Run parameters, such as the phase of a breath, are left to the table.
    """
    rows, at = [], len(fit.subject)
    for effect, values in fit.uses:
        size = int(effect.is_continuous.sum())
        known = iter(table.parameters[at : at + size] if table else ())
        if effect.spread is not None:
            rows.append(_spread_row(effect, fit.spread, size))
        else:
            for p, v in zip(effect.parameters, values, strict=False):
                moved = None if p.choices else next(known, None)
                rows.append(estimate_row(moved) if moved else _value_row(p, v))
        at += len(effect.run_parameters) * fit.num_runs + size
    return rows


def _value_row(parameter, value) -> dict:
    at_limit = value <= parameter.lower or value >= parameter.upper
    return {
        "name": parameter.name,
        "unit": parameter.unit,
        "value": float(value),
        "standard_error": None,
        "lower95": None,
        "upper95": None,
        "at_limit": bool(at_limit and not parameter.choices),
    }


def _spread_row(effect: Effect, spread: float, count: int) -> dict:
    """A standard deviation estimated from `count` draws."""
    name, unit = effect.spread
    error = spread / np.sqrt(2.0 * count)
    return {
        "name": name,
        "unit": unit,
        "value": spread,
        "standard_error": error,
        "lower95": spread - 1.96 * error,
        "upper95": spread + 1.96 * error,
        "at_limit": False,
    }


def estimate_row(p: ParameterEstimate) -> dict:
    """One estimate in plain types."""
    return {
        "name": p.name,
        "unit": p.unit,
        "value": p.value,
        "standard_error": p.standard_error,
        "lower95": p.lower95,
        "upper95": p.upper95,
        "at_limit": p.at_limit,
    }
