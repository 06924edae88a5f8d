"""A diagnosis as the document that is written down."""

from __future__ import annotations

import hashlib
import importlib.metadata

import numpy as np

from brace_drake.design.next_run import describe_next
from brace_drake.diagnose import Diagnosis
from brace_drake.document.rows import (
    cause_rows,
    effect_parameters,
    estimate_row,
)
from brace_drake.document.verdict_text import verdict_sentence
from brace_drake.identification.gap import is_repaired
from brace_drake.isolation.block_tests import describe_unchecked
from brace_drake.recording.recording import Campaign
from brace_drake.recording_faults.finding import recording_verdict

FORMAT = "brace-diagnosis/1"


def MakeDocument(d: Diagnosis) -> dict:
    """The diagnosis in plain JSON types, format brace-diagnosis/1."""
    verdict, winner = d.verdict, d.verdict.winner
    effects = winner.effects if winner else ()
    table, own = d.estimates, d.estimates.num_subject
    closed = d.shrinkage["closed"] if d.shrinkage else None
    values = effect_parameters(winner, d.estimates) if winner else ()
    return _plain(
        {
            "format": FORMAT,
            "campaign": d.campaign.name,
            "device": d.campaign.device,
            "subject_name": d.campaign.subject,
            "verdict": {
                "gap": verdict.gap,
                "effects": [e.name for e in effects],
                "blocks": d.blocks,
                "outside_library": verdict.outside_library,
                "ambiguous_with": list(verdict.ambiguous_with),
                "probability": verdict.probability,
                "sentence": verdict_sentence(
                    d.campaign.name, effects, verdict.gap, closed, values
                ),
                **recording_verdict(d.recording),
            },
            "where": d.where,
            "causes": cause_rows(d),
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
            "provenance": _provenance(d),
        }
    )


def _warnings(d: Diagnosis) -> list[str]:
    """What a reader has to know beside the verdict, sentence by sentence."""
    winner = d.verdict.winner
    found = [str(p) for p in d.campaign.warnings]
    found += [str(p) for f in d.recording for p in f.problems()]
    tests = d.device.block_tests
    found += describe_unchecked(d.evaluator, tests, d.block_tests)
    for channel, ratio in d.floor_ratios.items():
        found.append(
            f"{channel}: the noise between repeats has {ratio:.2f} times the"
            " variance of the twin's noise; the repeats' was taken"
        )
    if not any(r.repeat_of for r in d.campaign.runs):
        found.append(
            "no run was repeated: the noise floor rests on the twin alone"
        )
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
    if winner is not None:
        rest = d.criterion.misfit(winner)
        if rest > d.criterion.null.misfit_threshold:
            found.append(
                f"with the repair the fit runs are {np.sqrt(1.0 + rest):.2f}"
                " times the floor off, more than noise: another, smaller effect"
                " may hide in that"
            )
    if d.is_cut:
        found.append(
            "the search for two effects at once ended at its limit of replays:"
            " pairs of which less was predicted were not tried"
        )
    found += [
        f"{p.name} is at its limit {p.value:.4g} {p.unit}"
        for p in d.estimates.parameters
        if p.at_limit
    ]
    found += [
        f"{p.name}: the fit runs say nothing of it, {p.value:.4g} {p.unit} is"
        " where the fit began"
        for p in d.estimates.parameters
        if p.standard_error is None
    ]
    return found


def _provenance(d: Diagnosis) -> dict:
    """What the diagnosis was made from, and the thresholds it rests on."""
    null = d.criterion.null
    packages = ("brace_drake", "drake", "numpy", "scipy", "numba")
    return {
        "data_sha256": campaign_hash(d.campaign),
        "seed": d.seed,
        "time_step_s": d.device.twin.time_step,
        "misfit": d.criterion.misfit(d.nominal),
        "misfit_threshold": null.misfit_threshold,
        "gain_threshold": null.least_gain(1),
        "gain_threshold_of_six_parameters": null.least_gain(6),
        "integration_error": null.numerical,
        "smallest_explained_share": d.criterion.least_share,
        "probability_is": "from what the best rival and the winner leave,"
        " calibrated on 165 withheld cases of an independent simulator",
        "versions": {p: importlib.metadata.version(p) for p in packages},
    }


def campaign_hash(campaign: Campaign) -> str:
    """SHA-256 over the campaign's files in the order of their names."""
    digest = hashlib.sha256()
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
