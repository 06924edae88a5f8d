"""A diagnosis as the document that is written down."""

from __future__ import annotations

import hashlib
import importlib.metadata

import numpy as np

from brace_drake.design.next_run import describe_next
from brace_drake.diagnosis import Diagnosis
from brace_drake.document.law_rows import law_row, law_sentence
from brace_drake.document.origin import Origin, origin_rows, run_rows
from brace_drake.document.rows import (
    cause_rows,
    estimate_row,
    real_rivals,
    rest_text,
    supported_rows,
    tolerance_rows,
)
from brace_drake.document.verdict_text import (
    controller_text,
    off_text,
    stated_text,
    verdict_sentence,
)
from brace_drake.identification.gap import is_repaired
from brace_drake.isolation.block_tests import describe_unchecked
from brace_drake.recording.recording import Campaign
from brace_drake.recording_faults.finding import recording_verdict
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import cost_of

FORMAT = "brace-diagnosis/2"
# Readings with less of their noise than this have gone through a filter.
_FILTERED = 0.1


def MakeDocument(d: Diagnosis, origin: Origin | None = None) -> dict:
    """The diagnosis in plain JSON types, format brace-diagnosis/2.

    Args:
        d: The diagnosis.
        origin: Command and scenario that it comes from, and when; without,
            it was called from Python just now.
    """
    verdict, table = d.verdict, d.estimates
    causes = cause_rows(d)
    own = table.num_subject
    closed = d.shrinkage["closed"] if d.shrinkage else None
    off = d.shrinkage["after"] if d.shrinkage else None
    moved = tolerance_rows(d)
    supported = supported_rows(d)
    told = {
        "gap": verdict.gap,
        "effects": [row["effect"] for row in supported],
        "supported": supported,
        "blocks": d.blocks,
        "unexplained": _unexplained(d),
        "outside_library": verdict.outside_library,
        "ambiguous_with": real_rivals(d, causes),
        "probability": verdict.probability,
        "confirmed": confirmed(d),
        "contradicted": verdict.contradicted or None,
    }
    name = d.campaign.name
    told["sentence"] = verdict_sentence(name, told, closed, moved, off)
    told["sentence"] += law_sentence(told["unexplained"]["law"])
    told["sentence"] += controller_text(d.block_tests)
    told["sentence"] += stated_text(
        d.campaign.nominal, d.estimates.parameters[: d.estimates.num_subject]
    )
    told |= recording_verdict(d.recording)
    return _plain(
        {
            "format": FORMAT,
            "campaign": d.campaign.name,
            "device": d.campaign.device,
            "subject_name": d.campaign.subject,
            "verdict": told,
            "where": d.where,
            "causes": causes,
            "tolerances": moved,
            "subject": {
                "parameters": [
                    {**estimate_row(p), "nominal": p.nominal}
                    for p in table.parameters[:own]
                ],
                "condition_number": table.condition_number,
                "correlation": table.correlation[:own, :own].tolist(),
            },
            "shrink": d.shrinkage,
            "left": d.rest,
            "next_experiment": describe_next(verdict, d.blocks, d.next_run),
            "warnings": _warnings(d),
            "runs": run_rows(d),
            "provenance": origin_rows(d, origin or Origin()) | _provenance(d),
        }
    )


def confirmed(d: Diagnosis) -> bool | None:
    """Whether the validation runs confirm the verdict; None where they tell
    nothing: without any, where the repaired twin breaks down on them, and
    where they do not show the gap.
    """
    verdict, shrinkage = d.verdict, d.shrinkage
    if verdict.contradicted:
        return False
    if shrinkage is None:
        return None
    if verdict.effects:
        return True if shrinkage["closed"] is not None else None
    most = np.sqrt(1.0 + d.criterion.beyond)
    if verdict.gap and shrinkage["before"] <= most:
        return None
    return True


def _unexplained(d: Diagnosis) -> dict:
    """What is left: its share, in which block, and what it goes with."""
    verdict = d.verdict
    share = verdict.unexplained if verdict.gap else 0.0
    named = {row["block"] for row in supported_rows(d)}
    rest = [b for b in d.blocks if b not in named] if share else []
    shape = d.rest[0] if share and d.rest else None
    return {
        "share": share,
        "block": next(iter(rest or d.blocks), None) if share else None,
        "description": rest_text(shape) if shape else "",
        "law": law_row(d.law),
    }


def _warnings(d: Diagnosis) -> list[str]:
    """What a reader has to know beside the verdict, sentence by sentence."""
    winner = d.verdict.winner
    found = [str(p) for p in d.campaign.warnings]
    found += [str(p) for f in d.recording for p in f.problems()]
    tests = d.device.block_tests
    found += describe_unchecked(d.evaluator, tests, d.block_tests)
    for channel, ratio in d.floor_ratios.items():
        text = (
            f"{channel}: the noise between repeats has {ratio:.2g} times the"
            " variance of the twin's noise; the repeats' was taken"
        )
        if ratio < _FILTERED:
            text += "; filters shift and smear: record raw readings"
        found.append(text)
    if not any(r.repeat_of for r in d.campaign.runs):
        found.append(
            "no run was repeated: the noise floor rests on the twin alone"
        )
    found += [
        f"{name}: a copy of a fit run, which confirms nothing; left out"
        for name in d.copies
    ]
    if d.verdict.contradicted:
        found.append(f"withdrawn: {d.verdict.contradicted}")
    if not d.validation_runs:
        found.append("no validation run: how far the gap shrinks is unknown")
    elif winner is not None and not is_repaired(d.validation_runs):
        found.append(
            "the repaired twin breaks down on the validation runs: how far the"
            " gap shrinks is unknown"
        )
    if winner is not None and winner.has_run_parameters:
        found.append(
            "what each run has of its own, such as the phase of a breath, was"
            " estimated on the validation runs themselves; all else was not"
        )
    if winner is not None and d.criterion.is_beyond_level(winner):
        rest = max(0.0, d.criterion.misfit(winner))
        found.append(
            f"with the repair the fit runs are {np.sqrt(1.0 + rest):.2f}"
            " times the floor off, more than noise: another, smaller effect"
            " may hide in that"
        )
    found += map(off_text, tolerance_rows(d))
    if d.nuisances and not d.device.twin.scenario.tolerances.is_stated:
        found.append("the scenario states no tolerances: defaults were assumed")
    found += [
        f"{p.name} is at its limit {p.value:.4g} {p.unit}"
        for p in d.estimates.parameters
        if p.at_limit
    ]
    found += [
        f"{p.name}: the fit runs say nothing of it, {p.value:.4g} {p.unit} is"
        " where the fit began"
        for p in d.estimates.parameters
        if p.standard_error is None and not p.fixed
    ]
    found += d.choice.contradicted(
        {p.name: p.value for p in d.estimates.parameters}
    )
    if d.choice.limits_search:
        found.append(
            "the search was limited to"
            f" {', '.join(dict.fromkeys(e.name for e in d.evaluator.effects))}:"
            " what else there is would be taken for one of these, or for none"
        )
    return found


def _provenance(d: Diagnosis) -> dict:
    """What the diagnosis was made from, and the numbers it rests on."""
    packages = ("brace_drake", "drake", "numpy", "scipy", "numba")
    criterion = d.criterion
    return {
        "data_sha256": campaign_hash(d.campaign),
        "scenario": d.scenario.describe(d.device.twin.scenario),
        "choice": d.choice.describe(),
        "seed": d.seed,
        "time_step_s": d.device.twin.time_step,
        "misfit": criterion.misfit(d.nominal),
        "level": criterion.level,
        "costs_of_effects": [
            cost_of(n + 1) for n in range(thresholds.MOST_EFFECTS)
        ],
        "material_share": thresholds.MATERIAL,
        "replays": d.evaluator.replays,
        "probability_is": "from the scores of all explanations, calibrated on"
        " withheld cases of an independent simulator",
        "versions": {p: importlib.metadata.version(p) for p in packages},
    }


def campaign_hash(campaign: Campaign) -> str:
    """SHA-256 over the campaign's files in the order of their names; over its
    channels where it was never written.
    """
    digest = hashlib.sha256()
    if not (campaign.path / "campaign.yaml").is_file():
        for run in sorted(campaign.runs, key=lambda r: r.file):
            for name, values in sorted(run.channels.items()):
                digest.update(f"{run.file} {name}".encode())
                digest.update(np.ascontiguousarray(values).tobytes())
        return digest.hexdigest()
    files = ["campaign.yaml", *sorted(run.file for run in campaign.runs)]
    for name in files:
        digest.update(name.encode())
        digest.update((campaign.path / name).read_bytes())
    return digest.hexdigest()


def _plain(value):
    """Numpy and non-finite numbers as JSON knows them."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    if isinstance(value, (int, np.integer)):
        return int(value)
    return value
