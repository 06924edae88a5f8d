"""Causes and parameters of a diagnosis as rows of its document."""

from __future__ import annotations

import numpy as np

from brace_drake.diagnose import Diagnosis
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.intervals import (
    EstimateTable,
    ParameterEstimate,
)
from brace_drake.isolation.block_tests import holds_at_rest
from brace_drake.validation.causes import untried_at_rest


def cause_rows(d: Diagnosis) -> list[dict]:
    """Every candidate, ranked, then those that were not tried as there is
    nothing of them at rest.
    """
    rows = []
    for cause in d.causes:
        fit, is_winner = cause.fit, cause.fit is d.verdict.winner
        surrogates, seen = cause.surrogates, cause.prediction
        rows.append(
            {
                "effect": fit.name,
                "chosen": is_winner,
                "block": "+".join(dict.fromkeys(e.block for e in fit.effects)),
                "title": " and ".join(e.title for e in fit.effects),
                "excess": d.criterion.misfit(fit),
                "held_out": cause.held_out,
                "decoys": surrogates
                and dict(
                    zip(
                        ("number", "taken", "best_decoy"),
                        surrogates,
                        strict=True,
                    )
                ),
                "explained": max(0.0, d.criterion.closed(fit)),
                "validation": seen
                and {
                    "gap": seen.gap,
                    "lower95": seen.interval[0],
                    "upper95": seen.interval[1],
                },
                "searched": fit.is_searched,
                "converged": fit.refined,
                "identifiable": not cause.is_tied,
                "decision": cause.decision,
                "parameters": effect_parameters(
                    fit, d.estimates if is_winner else None
                ),
            }
        )
    if not (d.verdict.gap and holds_at_rest(d.block_tests)):
        return rows
    nothing = dict.fromkeys(("held_out", "decoys", "validation"))
    for effect in untried_at_rest(d.evaluator.twin.device, d.fits):
        row = {"effect": effect.name, "block": effect.block}
        row |= nothing | {"title": effect.title, "explained": 0.0}
        row |= dict.fromkeys(("chosen", "searched", "converged"), False)
        row["excess"] = d.criterion.misfit(d.nominal)
        row["decision"] = "nothing of it in the leg lengths at rest"
        rows.append(row | {"identifiable": True, "parameters": []})
    return rows


def effect_parameters(
    fit: CandidateFit, table: EstimateTable | None
) -> list[dict]:
    """Fitted parameters of a candidate; with intervals where `table` is.

    Run parameters, such as the phase of a breath, are left to the table.
    """
    rows, at = [], len(fit.subject)
    for effect, values in fit.uses:
        size = int(effect.is_continuous.sum())
        known = iter(table.parameters[at : at + size] if table else ())
        at += len(effect.run_parameters) * fit.num_runs + size
        if effect.spread is not None:
            # A standard deviation estimated from so many draws.
            name, unit = effect.spread
            error = fit.spread / np.sqrt(2.0 * size)
            row = {"name": name, "unit": unit, "value": fit.spread}
            row |= {"standard_error": error, "at_limit": False}
            row["lower95"] = fit.spread - 1.96 * error
            row["upper95"] = fit.spread + 1.96 * error
            rows.append(row)
            continue
        for p, value in zip(effect.parameters, values, strict=False):
            estimate = None if p.choices else next(known, None)
            if estimate is not None:
                rows.append(estimate_row(estimate))
                continue
            row = {"name": p.name, "unit": p.unit, "value": float(value)}
            row |= dict.fromkeys(("standard_error", "lower95", "upper95"))
            is_beyond = value <= p.lower or value >= p.upper
            row["at_limit"] = bool(is_beyond and not p.choices)
            rows.append(row)
    return rows


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
