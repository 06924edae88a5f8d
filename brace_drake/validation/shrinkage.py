"""How far the gap shrinks on runs that no fit has seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import Device
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import (
    RunComparison,
    closed_share,
    compare_runs,
    interval_of_rms,
    is_repaired,
    repair_runs,
    rms_gap,
)
from brace_drake.validation.run_parameters import adapt_to_runs


def compare_new_runs(
    validation: Evaluator, nominal: CandidateFit, winner: CandidateFit | None
) -> list[RunComparison]:
    """Runs that no fit has seen, before the repair and after it; before it
    alone where the repaired twin breaks down on them.
    """
    compared = compare_runs(validation, nominal, None)
    if winner is None or not compared:
        return compared
    try:
        return repair_new_runs(validation, compared, winner)
    except BraceError:
        return compared


def repair_new_runs(
    validation: Evaluator, compared: Sequence[RunComparison], fit: CandidateFit
) -> list[RunComparison]:
    """The same runs with a fit's replays as those after the repair; what a run
    has of its own is estimated on it.

    Raises:
        BraceError: Its twin breaks down in one of them.
    """
    fit = adapt_to_runs(validation, fit)
    return repair_runs(validation, compared, fit)


def measure_shrinkage(
    device: Device,
    compared: Sequence[RunComparison],
    subject: np.ndarray,
    seed: int,
) -> dict | None:
    """Before, after and closed share on validation runs; None without.

    Args:
        device: Of the campaign.
        compared: Validation runs, from `compare_new_runs`.
        subject: Values of the nominal fit.
        seed: Of the intervals.
    """
    if not compared:
        return None
    repaired = is_repaired(compared)
    which = "after" if repaired else "before"
    before, after = rms_gap(compared, "before"), rms_gap(compared, which)
    parts = [[c.squares(w) for c in compared] for w in ("before", which)]
    ends = [interval_of_rms(compared, [part], seed) for part in parts]
    interval, channels = None, []
    if repaired:
        interval = interval_of_rms(compared, parts, seed, closed_share)
    for c, name in enumerate(device.twin.channels):
        mine, then = (rms_gap(compared, w, c) for w in ("before", which))
        if mine is None:
            continue
        squares = [run.squares(which)[:, c] for run in compared]
        row = {"channel": name, "unit": name.rsplit("_", 1)[-1]}
        row |= {"before": mine, "after": then, "floor": 1.0}
        row["after_interval"] = interval_of_rms(compared, [squares], seed)
        row["closed"] = closed_share(mine, then) if repaired else None
        channels.append(row)
    return {
        "runs": [c.prepared.run.name for c in compared],
        "before": before,
        "before_interval": ends[0],
        "after": after,
        "after_interval": ends[1],
        "floor": 1.0,
        "closed": closed_share(before, after) if repaired else None,
        "closed_interval": interval,
        "channels": channels,
        **_quantities(device, compared, subject, seed),
    }


def _quantities(device, compared, subject, seed) -> dict:
    """Errors in the units a user thinks in, over the validation runs.

    Root mean squares before and after, of the floor, and of the measured
    signal itself; 95 % intervals of the first two.
    """
    twin, squares = device.twin, {}
    for c in compared:
        prepared = c.prepared
        generator = np.random.default_rng([seed, 31, prepared.seed])
        exact = twin.simulate(prepared.motion, subject)
        noisy = twin.simulate(prepared.motion, subject, (), generator)
        after = c.before if c.after is None else c.after
        pairs = {
            "before": (prepared.measured, c.before),
            "after": (prepared.measured, after),
            "floor": (exact, noisy),
            "signal": (prepared.measured, None),
        }
        for which, (first, second) in pairs.items():
            values = device.quantities(first)
            others = None if second is None else device.quantities(second)
            for name, series in values.items():
                error = series - others[name] if others else series
                row = squares.setdefault(name, {})
                row.setdefault(which, []).append(np.sum(error**2, axis=1))
    found = {}
    for name, row in squares.items():
        found[name] = {
            which: float(np.sqrt(np.mean(np.concatenate(values))))
            for which, values in row.items()
        }
        for which in ("before", "after"):
            interval = interval_of_rms(compared, [row[which]], seed)
            found[name][f"{which}_interval"] = interval
        title, unit = device.words[name]
        found[name] |= {"title": title, "unit": unit}
    return found
