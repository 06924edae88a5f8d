"""A diagnosis as the document that is written down."""

from __future__ import annotations

import hashlib
import importlib.metadata

import numpy as np

from brace_drake.campaign.recording import Campaign
from brace_drake.effects.card import Effect
from brace_drake.gap import shrink, verdict
from brace_drake.gap.budget import (
    band_budget,
    channel_budget,
    motion_phases,
    phase_budget,
)
from brace_drake.gap.diagnose import Diagnosis
from brace_drake.gap.uncertainty import EstimateTable, ParameterEstimate
from brace_drake.gap.verdict_text import next_experiment, verdict_sentence

FORMAT = "brace-diagnosis/1"


def MakeDocument(d: Diagnosis) -> dict:
    """The diagnosis in plain JSON types, format brace-diagnosis/1."""
    winner = d.verdict.winner
    effects = [e.name for e in winner.effects] if winner else []
    where = _where(d)
    shrunk = _shrink(d)
    closed = shrunk["closed"] if shrunk else None
    blocks = (
        list(dict.fromkeys(e.block for e in winner.effects)) if winner else []
    )
    if d.verdict.outside_library:
        blocks = _accused(d.ladder)
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
                    effects,
                    d.verdict.gap,
                    closed,
                    _values_text(d, winner),
                ),
            },
            "where": where,
            "causes": _causes(d),
            "subject": _subject(d.table),
            "shrink": shrunk,
            "next_experiment": next_experiment(
                effects,
                d.verdict.ambiguous_with,
                d.verdict.outside_library,
                d.ladder,
            ),
            "warnings": _warnings(d),
            "receipt": _receipt(d),
        }
    )


def _accused(ladder: list[dict]) -> list[str]:
    """The block with the largest share, where one is accused at all."""
    accused = [r for r in ladder if not r["acquitted"]]
    known = [r for r in accused if r["block"] != "controller"]
    if not known:
        return []
    return [max(known, key=lambda r: r["share"])["block"]]


def _where(d: Diagnosis) -> dict:
    channels, rate = d.device.twin.channels, d.campaign.rate_hz
    reference = d.fit_runs[-1].prepared.floor.rms
    floor = dict(zip(channels, reference, strict=True))
    phases = []
    for comparison in d.fit_runs:
        prepared = comparison.prepared
        position, force = d.device.phase_inputs(prepared)
        phases.append(
            motion_phases(position, force, rate, prepared.run.contact)
        )
    return {
        "blocks": d.ladder,
        "channels": channel_budget(d.fit_runs, channels, floor),
        "phases": phase_budget(d.fit_runs, phases),
        "bands": band_budget(d.fit_runs, rate),
    }


def _causes(d: Diagnosis) -> list[dict]:
    rows = []
    winner = d.verdict.winner
    for fit in sorted(d.fits, key=lambda f: f.excess):
        is_winner = winner is not None and fit.name == winner.name
        estimates = d.table if is_winner else None
        rows.append(
            {
                "effect": fit.name,
                "block": "+".join(dict.fromkeys(e.block for e in fit.effects)),
                "title": " and ".join(e.title for e in fit.effects),
                "excess": verdict.misfit(d.evaluator, fit),
                "explained": max(
                    0.0,
                    verdict.closed_amplitude(d.evaluator, d.nominal, fit),
                ),
                "converged": fit.name in d.refined,
                "identifiable": fit.name not in d.verdict.ambiguous_with,
                "decision": _decision(d, fit, is_winner),
                "parameters": _effect_parameters(fit, estimates),
            }
        )
    return rows


def _decision(d: Diagnosis, fit, is_winner: bool) -> str:
    if is_winner:
        return "explains the gap"
    if not d.verdict.gap:
        return "no gap to explain"
    if fit.name in d.verdict.ambiguous_with:
        return "as good as the first on these data"
    gain = verdict.gain(d.evaluator, d.nominal, fit)
    if gain <= d.null.gain_threshold:
        return "gains no more than noise would"
    rest = 1.0 + max(0.0, verdict.misfit(d.evaluator, fit))
    return f"leaves {np.sqrt(rest):.1f} times the floor on the fit runs"


def _effect_parameters(fit, table: EstimateTable | None) -> list[dict]:
    rows, at = [], len(fit.subject)
    for effect, values in fit.uses:
        size = len(effect.parameters)
        known = table.parameters[at : at + size] if table else None
        if effect.spread is not None:
            rows.append(_spread_row(effect, fit.spread, size))
        elif known:
            rows += [_estimate_row(p) for p in known]
        else:
            rows += [
                {
                    "name": p.name,
                    "unit": p.unit,
                    "value": float(v),
                    "standard_error": None,
                    "lower95": None,
                    "upper95": None,
                    "at_limit": bool(v <= p.lower or v >= p.upper),
                }
                for p, v in zip(effect.parameters, values, strict=True)
            ]
        at += size
    return rows


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


def _estimate_row(p: ParameterEstimate) -> dict:
    return {
        "name": p.name,
        "unit": p.unit,
        "value": p.value,
        "standard_error": p.standard_error,
        "lower95": p.lower95,
        "upper95": p.upper95,
        "at_limit": p.at_limit,
    }


def _subject(table: EstimateTable) -> dict:
    n = table.num_subject
    return {
        "parameters": [
            {**_estimate_row(p), "nominal": p.nominal}
            for p in table.parameters[:n]
        ],
        "condition_number": table.condition_number,
        "correlation": table.correlation[:n, :n].tolist(),
    }


def _shrink(d: Diagnosis) -> dict | None:
    if not d.validation_runs:
        return None
    runs, repaired = d.validation_runs, d.verdict.winner is not None
    after_key = "after" if repaired else "before"
    before = shrink.total_gap(runs, "before")
    after = shrink.total_gap(runs, after_key)
    channels = d.device.twin.channels
    by_before = shrink.channel_gaps(runs, channels, "before")
    by_after = shrink.channel_gaps(runs, channels, after_key)
    interval = None
    if repaired:
        interval = shrink.closed_interval(runs, d.campaign.rate_hz, d.seed)
    return {
        "runs": [c.prepared.run.name for c in runs],
        "before": before,
        "after": after,
        "floor": 1.0,
        "closed": shrink.closed_share(before, after) if repaired else None,
        "closed_interval": interval,
        "channels": [
            {
                "channel": name,
                "unit": name.rsplit("_", 1)[-1],
                "before": value,
                "after": by_after[name],
                "floor": 1.0,
                "closed": shrink.closed_share(value, by_after[name])
                if repaired
                else None,
            }
            for name, value in by_before.items()
        ],
        **_quantities(d, repaired),
    }


def _quantities(d: Diagnosis, repaired: bool) -> dict:
    """Errors in the units a user thinks in, over the validation runs.

    Root mean squares before and after, of the floor, and of the measured
    signal itself.
    """
    twin, squares = d.device.twin, {}
    for comparison in d.validation_runs:
        prepared = comparison.prepared
        measured = d.device.quantities(twin, prepared.measured)
        generator = np.random.default_rng([d.seed, 31, prepared.seed])
        exact = twin.simulate(prepared.motion, d.nominal.subject)
        noisy = twin.simulate(prepared.motion, d.nominal.subject, (), generator)
        versions = {
            "before": comparison.before,
            "after": comparison.after if repaired else comparison.before,
        }
        floors = (
            d.device.quantities(twin, exact),
            d.device.quantities(twin, noisy),
        )
        for name, series in measured.items():
            row = squares.setdefault(
                name, {"before": [], "after": [], "floor": [], "signal": []}
            )
            row["signal"].append(np.sum(series**2, axis=1))
            for which, simulated in versions.items():
                other = d.device.quantities(twin, simulated)[name]
                row[which].append(np.sum((series - other) ** 2, axis=1))
            row["floor"].append(
                np.sum((floors[0][name] - floors[1][name]) ** 2, axis=1)
            )
    return {
        name: {
            which: float(np.sqrt(np.mean(np.concatenate(values))))
            for which, values in row.items()
        }
        for name, row in squares.items()
    }


def _values_text(d: Diagnosis, winner) -> str:
    if winner is None:
        return ""
    rows = _effect_parameters(winner, d.table)
    return ", ".join(f"{r['name']} {r['value']:.4g}" for r in rows)


def _warnings(d: Diagnosis) -> list[str]:
    found = [str(p) for p in d.campaign.warnings]
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
    found += [
        f"{p.name} is at its limit {p.value:.4g} {p.unit}"
        for p in d.table.parameters
        if p.at_limit
    ]
    return found


def _receipt(d: Diagnosis) -> dict:
    packages = ("brace_drake", "drake", "numpy", "scipy", "numba")
    return {
        "data_sha256": campaign_hash(d.campaign),
        "seed": d.seed,
        "time_step_s": d.device.twin.time_step,
        "misfit": verdict.misfit(d.evaluator, d.nominal),
        "misfit_threshold": d.null.misfit_threshold,
        "gain_threshold": d.null.gain_threshold,
        "integration_error": d.null.numerical,
        "smallest_explained_share": verdict.MAJOR,
        "probability_is": "share of campaigns, resampled by runs, with the"
        " same answer; not yet calibrated on withheld effects",
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
