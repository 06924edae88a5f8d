"""What a planned campaign could tell apart, before anything is recorded."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.core.parallel import Workers
from brace_drake.design.confusable import reason_of
from brace_drake.design.planned import planned_floors, planned_runs
from brace_drake.design.signature import (
    Signature,
    SignatureMaker,
    cosines,
    is_strength,
)
from brace_drake.devices.device import check_room
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.recording.recording import Run

FORMAT = "brace-plan/1"

# Signatures with a larger |cos| count as one.
INSEPARABLE = 0.95
# Length of a signature that stands out of the noise, standard deviations.
_SEEN = 5.0
# Standard errors beyond this part of a value determine nothing.
_POOR, _POOR_SUBJECT = 0.5, 0.1


def plan_campaign(
    twin,
    runs: Sequence[Run],
    rate: float,
    effects: Sequence[Effect] | None = None,
    jobs: int | Workers = 2,
    seed: int = 0,
    say: Callable[[str, float], None] = lambda what, share: None,
) -> dict:
    """What runs of given references would show of each effect.

    Args:
        twin: Of the bench; its scenario is the subject.
        runs: References, evenly sampled.
        rate: Of their samples, Hz.
        effects: Cards; None: all of the device.
        jobs: Threads, or workers; the result does not depend on their number.
        seed: Of the noise that floors and dithers are made of.
        say: Progress.

    Returns:
        A document of plain types, format brace-plan/1.

    Raises:
        CampaignError: No run.
        ScenarioError: The twin carries as many effects as it can.
    """
    if not runs:
        raise CampaignError("a plan needs one motion at least")
    check_room(twin)
    say("noise floor", 0.0)
    subject = np.array([p.nominal for p in twin.subject])
    floors = planned_floors(twin, runs, subject, rate, seed)
    prepared = planned_runs(twin, runs, floors, rate, seed)
    maker = SignatureMaker(Evaluator(twin, prepared, jobs), subject)
    if effects is None:
        effects = list(twin.effects().values())
    signatures, broken = [], []
    for i, effect in enumerate(effects):
        say(f"effect {effect.key}", (i + 0.5) / (len(effects) + 1))
        made = maker.make(effect)
        if made is None:
            broken.append(effect.key)
        else:
            signatures.append(made)
    matrix = cosines(signatures)
    rows = [_effect_row(s) for s in signatures]
    unseen = {row["effect"] for row in rows if row["least_size"] is None}
    return {
        "format": FORMAT,
        "runs": [r.name for r in runs],
        "effects": rows,
        "unseen": sorted(unseen),
        "broken": broken,
        "cosines": matrix.tolist(),
        "pairs": pair_rows(signatures, matrix),
        "undetermined": [
            *_poor_subject(twin, maker.subject_columns),
            *(
                row
                for s in signatures
                if s.effect.key not in unseen
                for row in _poor_parameters(s)
            ),
        ],
        "inseparable_above": INSEPARABLE,
        "seed": seed,
    }


def pair_rows(
    signatures: Sequence[Signature], matrix: np.ndarray
) -> list[dict]:
    """Pairs of different effects that the runs do not tell apart."""
    rows = []
    for i, j in itertools.combinations(range(len(signatures)), 2):
        first, second = signatures[i].effect, signatures[j].effect
        if first.name == second.name or not matrix[i, j] > INSEPARABLE:
            continue
        rows.append(
            {
                "effects": [first.key, second.key],
                "cosine": float(matrix[i, j]),
                "reason": reason_of(first, second),
            }
        )
    return sorted(rows, key=lambda row: -row["cosine"])


def _effect_row(s: Signature) -> dict:
    """Size, length and reach of a signature, for its leading parameter.

    `least_size` stands out of the noise; None where the limits forbid it.
    """
    lead = next(i for i in range(len(s.values)) if is_strength(s.effect, i))
    parameter = s.effect.parameters[lead]
    size = abs(float(s.values[lead]) - parameter.off)
    room = max(parameter.upper - parameter.off, parameter.off - parameter.lower)
    least = size * _SEEN / s.norm if s.norm > 0.0 else np.inf
    return {
        "effect": s.effect.key,
        "block": s.effect.block,
        "parameters": dict(
            zip(s.effect.parameter_names, map(float, s.values), strict=True)
        ),
        "gap_floors": s.rms,
        "norm": s.norm,
        "leading": parameter.name,
        "size": size,
        "norm_per_unit": s.norm / size if size > 0.0 else 0.0,
        "least_size": least if least <= room else None,
    }


def standard_errors(columns: np.ndarray) -> np.ndarray:
    """Of parameters with these sensitivities (rows, n), noise of variance 1.

    Infinite for parameters that the rows do not determine, alone or together
    with others.
    """
    size = np.linalg.norm(columns, axis=0)
    seen = np.flatnonzero(size > 0.0)
    errors = np.full(len(size), np.inf)
    if len(seen) == 0:
        return errors
    _, values, rows = np.linalg.svd(
        columns[:, seen] / size[seen], full_matrices=False
    )
    with np.errstate(divide="ignore"):
        spread = np.linalg.norm(rows / values[:, None], axis=0)
    errors[seen] = spread / size[seen]
    return errors


def _poor_parameters(s: Signature) -> list[dict]:
    """Parameters of an effect that stay open at this size."""
    if s.columns is None:
        return []
    continuous = np.flatnonzero(s.effect.is_continuous)
    rows = []
    for i, error in zip(continuous, standard_errors(s.columns), strict=True):
        parameter, value = s.effect.parameters[i], float(s.values[i])
        if error > _POOR * (abs(value) or parameter.typical):
            rows.append(_poor(s.effect.key, parameter, value, error))
    return rows


def _poor_subject(twin, columns: np.ndarray) -> list[dict]:
    rows = []
    errors = standard_errors(columns)
    for parameter, error in zip(twin.subject, errors, strict=True):
        if error > _POOR_SUBJECT:
            error = error * parameter.unit_step
            rows.append(_poor("subject", parameter, parameter.nominal, error))
    return rows


def _poor(of: str, parameter, value: float, error: float) -> dict:
    known = bool(np.isfinite(error))
    return {
        "of": of,
        "parameter": parameter.name,
        "unit": parameter.unit,
        "value": value,
        "standard_error": float(error) if known else None,
    }
