"""A diagnosis as the document that is written down."""

from __future__ import annotations

import hashlib
import importlib.metadata

import numpy as np

from brace_drake.design.next_run import NextRun, describe_next
from brace_drake.diagnose import Diagnosis
from brace_drake.document.cause_rows import (
    cause_rows,
    effect_parameters,
    estimate_row,
)
from brace_drake.document.shrink_part import shrink_part
from brace_drake.document.verdict_text import next_experiment, verdict_sentence
from brace_drake.identification.intervals import EstimateTable
from brace_drake.identification.run_parameters import has_run_parameters
from brace_drake.isolation.block_tests import describe_unchecked
from brace_drake.isolation.budget import (
    band_budget,
    channel_budget,
    phase_budget,
)
from brace_drake.isolation.cube import gap_cube
from brace_drake.isolation.decision import suspected_blocks
from brace_drake.isolation.force_balance import DRIVES
from brace_drake.isolation.phases import PHASES, motion_phases
from brace_drake.isolation.repair_shares import share_repairs
from brace_drake.isolation.residual_shapes import describe_left
from brace_drake.recording.recording import Campaign
from brace_drake.selection.criterion import refined
from brace_drake.validation.shrinkage import RunComparison, is_repaired

FORMAT = "brace-diagnosis/1"


def MakeDocument(d: Diagnosis, next_run: NextRun | None = None) -> dict:
    """The diagnosis in plain JSON types, format brace-diagnosis/1.

    Args:
        d: The diagnosis.
        next_run: From `choose_next_run`, where a cause is open.
    """
    winner = d.verdict.winner
    effects = [e.name for e in winner.effects] if winner else []
    where = _where(d)
    shrunk = shrink_part(d)
    closed = shrunk["closed"] if shrunk else None
    blocks = (
        list(dict.fromkeys(e.block for e in winner.effects)) if winner else []
    )
    if d.verdict.outside_library:
        blocks = _nearest_block(d) or suspected_blocks(
            d.ladder, where["balance"], where["contact_side"]
        )
    return _plain(
        {
            "format": FORMAT,
            "campaign": d.campaign.name,
            "device": d.campaign.device,
            "subject_name": d.campaign.subject,
            "verdict": {
                "gap": d.verdict.gap,
                "effects": effects,
                "blocks": blocks,
                "outside_library": d.verdict.outside_library,
                "ambiguous_with": list(d.verdict.ambiguous_with),
                "probability": d.verdict.probability,
                "sentence": verdict_sentence(
                    d.campaign.name,
                    winner.effects if winner else (),
                    d.verdict.gap,
                    closed,
                    effect_parameters(winner, d.table) if winner else (),
                ),
            },
            "where": where,
            "causes": cause_rows(d),
            "subject": _subject(d.table),
            "shrink": shrunk,
            "left": _left(d),
            "next_experiment": describe_next(
                next_experiment(
                    effects,
                    d.verdict.ambiguous_with,
                    d.verdict.outside_library,
                    blocks,
                ),
                next_run,
            ),
            "warnings": _warnings(d),
            "receipt": _receipt(d),
        }
    )


def _nearest_block(d: Diagnosis) -> list[str]:
    """The block of a single effect that takes by far most of the gap.

    It is not what happens, its parameters being no draw or its rest too large,
    but what happens acts like it.
    """
    singles = [f for f in refined(d.fits) if len(f.effects) == 1]
    return [
        fit.effects[0].block
        for fit in singles[:1]
        if d.criterion.closed(fit) >= d.criterion.least_share
    ]


def _where(d: Diagnosis) -> dict:
    channels, rate = d.device.twin.channels, d.campaign.rate_hz
    reference = d.fit_runs[-1].prepared.floor.rms
    floor = dict(zip(channels, reference, strict=True))
    phases = [_phases(d, comparison) for comparison in d.fit_runs]
    return {
        "blocks": d.ladder,
        "contact_side": d.side.row() if d.side else None,
        "balance": _balance(d),
        "attribution": _attribution(d),
        "attribution_by": "repair" if d.verdict.winner else "errors",
        "channels": channel_budget(d.fit_runs, channels, floor),
        "phases": phase_budget(d.fit_runs, phases),
        "bands": band_budget(d.fit_runs, rate),
        "cube": gap_cube(d.fit_runs, phases, PHASES, channels, rate, d.seed)
        if d.verdict.gap
        else [],
    }


def _left(d: Diagnosis) -> list[dict]:
    if not d.verdict.gap:
        return []
    fit, twin = d.verdict.winner or d.nominal, d.device.twin
    signals = [
        d.device.motion_signals(twin, prepared, fit.subject)
        for prepared in d.evaluator.prepared
    ]
    return describe_left(d.evaluator, fit, signals, d.campaign.rate_hz, d.seed)


def _phases(d: Diagnosis, comparison: RunComparison) -> np.ndarray:
    prepared = comparison.prepared
    signals = d.device.motion_signals(
        d.device.twin, prepared, d.nominal.subject
    )
    breath = None
    if has_run_parameters(d.verdict.winner) and signals.force is not None:
        # What its repair changes while the brace holds still is the breath.
        breath = (comparison.after - comparison.before)[:, signals.force]
    return motion_phases(
        signals,
        prepared.measured,
        d.campaign.rate_hz,
        prepared.run.contact,
        breath,
    )


def _balance(d: Diagnosis) -> list[dict]:
    """Whose errors the balance of the leg forces shows, if nobody's effect
    explains the gap.
    """
    drives = next((r for r in d.ladder if r["block"] == DRIVES), None)
    if not d.verdict.outside_library or not drives or not d.device.balance:
        return []
    prepared, rate = d.evaluator.prepared, d.campaign.rate_hz
    return d.device.balance(d.device.twin, prepared, rate, drives)


def _attribution(d: Diagnosis) -> list[dict]:
    """Shares of the blocks: by repair, else by what their errors could do."""
    winner, rivals = d.verdict.winner, d.verdict.ambiguous_with
    if winner is not None:
        return share_repairs(d.evaluator, d.nominal, winner, rivals, d.seed)
    if not d.verdict.gap or d.device.attribute is None:
        return []
    return d.device.attribute(d.evaluator, d.nominal, d.seed)


def _subject(table: EstimateTable) -> dict:
    n = table.num_subject
    return {
        "parameters": [
            {**estimate_row(p), "nominal": p.nominal}
            for p in table.parameters[:n]
        ],
        "condition_number": table.condition_number,
        "correlation": table.correlation[:n, :n].tolist(),
    }


def _warnings(d: Diagnosis) -> list[str]:
    found = [str(p) for p in d.campaign.warnings]
    found += describe_unchecked(d.evaluator, d.device.rungs, d.ladder)
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
    elif d.verdict.winner is not None and not is_repaired(d.validation_runs):
        found.append(
            "the repaired twin breaks down on the validation runs: how far the"
            " gap shrinks is unknown"
        )
    if has_run_parameters(d.verdict.winner):
        found.append(
            "what each run has of its own, such as the phase of a breath, was"
            " estimated on the validation runs themselves; all else was not"
        )
    winner = d.verdict.winner
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
            " pairs that promised less were not tried"
        )
    found += [
        f"{p.name} is at its limit {p.value:.4g} {p.unit}"
        for p in d.table.parameters
        if p.at_limit
    ]
    found += [
        f"{p.name}: the fit runs say nothing of it, {p.value:.4g} {p.unit} is"
        " where the fit began"
        for p in d.table.parameters
        if p.standard_error is None
    ]
    return found


def _receipt(d: Diagnosis) -> dict:
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
