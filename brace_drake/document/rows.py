"""Causes and parameters of a diagnosis as rows of its document."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from brace_drake.devices.stretch import noise_along
from brace_drake.diagnosis import Diagnosis
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.held_out import estimate_off
from brace_drake.identification.intervals import (
    EstimateTable,
    ParameterEstimate,
)
from brace_drake.selection.same_model import simpler_twin

# Deviations by which the data move a number, to be listed.
_MOVED = 2.0


def cause_rows(d: Diagnosis) -> list[dict]:
    """Every candidate, ranked."""
    rows, fits = [], [cause.fit for cause in d.causes]
    for cause in d.causes:
        fit, is_winner = cause.fit, cause.fit is d.verdict.winner
        seen, same = cause.prediction, simpler_twin(cause.fit, fits)
        found = d.criterion.findings(fit)
        rows.append(
            {
                "effect": fit.name,
                "chosen": is_winner,
                "block": "+".join(dict.fromkeys(e.block for e in fit.effects)),
                "title": " and ".join(e.title for e in fit.effects),
                "within": [e.cause for e in fit.effects if e not in found],
                "score": cause.score,
                "excess": d.criterion.misfit(fit),
                "held_out": fit.held_out,
                "explained": max(0.0, d.criterion.closed(fit))
                if fit.is_searched
                else None,
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
                # A special case that it has come down to: the same model.
                "same_as": (same and not is_winner and same.name) or None,
                "parameters": effect_parameters(
                    fit, d.estimates if is_winner else None
                ),
            }
        )
    return rows


def real_rivals(d: Diagnosis, causes: Sequence[dict]) -> list[str]:
    """What the data cannot tell from the verdict, without what has come down
    to the verdict's own model.

    Args:
        d: The diagnosis.
        causes: From `cause_rows`.
    """
    chosen = {row["effect"] for row in causes if row["chosen"]}
    same = {
        "+".join(e.cause for e in d.criterion.findings(cause.fit))
        for cause, row in zip(d.causes, causes, strict=True)
        if row["same_as"] in chosen
    }
    return [name for name in d.verdict.ambiguous_with if name not in same]


def supported_rows(d: Diagnosis) -> list[dict]:
    """One row for each effect that is named, the largest first."""
    winner, rows = d.verdict.winner, []
    if winner is None:
        return rows
    table = parameters_by_effect(winner, d.estimates)
    cards = {e.cause: e for e in winner.effects}
    for support in d.verdict.supported:
        rows.append(
            {
                "effect": cards[support.name].name,
                # Which of its laws, and at which place.
                "form": cards[support.name].variant,
                "block": cards[support.name].block,
                "title": cards[support.name].title,
                "probability": support.probability,
                "closes": d.closed[support.name].share,
                "closes_interval": d.closed[support.name].interval,
                "parameters": table[support.name],
            }
        )
    return rows


def parameters_by_effect(
    fit: CandidateFit, table: EstimateTable | None
) -> dict[str, list[dict]]:
    """Rows of `effect_parameters` by cause."""
    rows, found = iter(effect_parameters(fit, table)), {}
    for effect in fit.effects:
        size = 1 if effect.spread else len(effect.parameters)
        found[effect.cause] = list(itertools.islice(rows, size))
    return found


def tolerance_rows(d: Diagnosis) -> list[dict]:
    """Numbers known to a tolerance that the data move by more than two
    deviations, the farthest first.
    """
    fit = d.verdict.winner or d.nominal
    if fit.tolerances is None:
        return []
    off = estimate_off(d.evaluator, fit)
    residual = fit.solution.residual[: d.evaluator.ends[-1]]
    known = fit.tolerances
    errors = known.errors(noise_along(known, known.along(residual)))
    rows = [
        {
            "name": n.name,
            "unit": n.unit,
            "block": n.block,
            "tolerance": n.deviation,
            "value": t * n.deviation,
            "standard_error": float(e) * n.deviation,
            "deviations": t,
        }
        for (n, t), e in zip(off, errors, strict=True)
        if abs(t) > _MOVED
    ]
    return sorted(rows, key=lambda r: -abs(r["deviations"]))


def rest_text(row: dict) -> str:
    """What is left in words, from a row of `describe_rest`."""
    if row["shape"] is None:
        return ""
    return f"goes with the {row['shape']}, as {row['acts_like']} would"


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
    """One estimate in plain types; `fixed` is there of what was held."""
    row = {
        "name": p.name,
        "unit": p.unit,
        "value": p.value,
        "standard_error": p.standard_error,
        "lower95": p.lower95,
        "upper95": p.upper95,
        "at_limit": p.at_limit,
    }
    return row | {"fixed": True} if p.fixed else row
