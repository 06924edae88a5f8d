"""The law of what is left as curves that a report draws."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.diagnosis import Diagnosis
from brace_drake.discrepancy.along_runs import (
    TermAlong,
    follow_law,
    kind_of_variable,
)
from brace_drake.effects.card import Effect
from brace_drake.effects.unknown import describe_term, parts_of_term
from brace_drake.effects.unknown.places import Place
from brace_drake.report.law_curve import LawCurve

_BINS = 24
# A bin of fewer samples says nothing of their spread.
_FEWEST = 8
_SPREAD = (5.0, 95.0)
# A unit as shown, and its factor.
_SHOWN = {"m": ("mm", 1e3), "m/s": ("mm/s", 1e3)}
_WORDS = ("", "speed", "load", "time")


def MakeLawCurves(d: Diagnosis) -> list[LawCurve]:
    """A curve for each term of the law; none without a law, or of another
    device than the bench.
    """
    if d.law is None or not isinstance(d.device.twin, BenchTwin):
        return []
    runs = [c.prepared for c in (*d.validation_runs, *d.fit_runs)]
    fit, rate = d.law.fit, d.campaign.rate_hz
    values = {e.name: v for e, v in fit.uses}
    found = follow_law(d.device.twin, fit.subject, fit.uses, runs, rate)
    return [
        _curve(effect, values[effect.name], along)
        for effect, along in found
        if along
    ]


def _curve(
    effect: Effect, values: np.ndarray, along: Sequence[TermAlong]
) -> LawCurve:
    place = parts_of_term(effect)[0]
    kind = kind_of_variable(effect)
    unit, factor = _SHOWN.get(place.units[kind], (place.units[kind], 1.0))
    shown, size = _SHOWN.get(place.unit, (place.unit, 1.0))
    if kind == 3:
        # Over time runs differ: the first one, which is held back if any is.
        along = along[:1]
    told = [a for a in along if a.lacks is not None]
    found, how = None, ""
    if told and kind == 3:
        x, lacks = _first(told[0])
        found = (
            x * factor,
            np.column_stack([lacks * size, *[lacks * np.nan] * 2]),
        )
        how = "the force that the twin lacks in that run, from measured signals"
    elif told:
        found = _bins(
            np.concatenate([a.x.ravel() for a in told]) * factor,
            np.concatenate([a.lacks.ravel() for a in told]) * size,
        )
        how = "the force that the twin lacks, from measured signals; mean and"
        how += f" {_SPREAD[0]:.0f} to {_SPREAD[1]:.0f} % of its samples"
    where = f" in run {along[0].run.run.name}" if kind == 3 else ""
    return LawCurve(
        text=describe_term(effect, values, np.full(len(values), np.nan))[
            "text"
        ],
        variable=f"{_WORDS[kind] or _variable(place)}{where}, {unit}",
        quantity=f"{_quantity(place)}, {shown}",
        runs=tuple(
            (a.run.run.name, a.run.run.split, x * factor, y * size)
            for a in along
            for x, y in zip(a.x.T, a.value.T, strict=True)
        ),
        found=found,
        found_words=how,
    )


def _variable(place: Place) -> str:
    """What the place of a term is called where it is drawn."""
    return "ring against torso" if place.key == "pads" else place.variable


def _quantity(place: Place) -> str:
    return "force of both pads" if place.key == "pads" else place.words


def _first(along: TermAlong) -> tuple[np.ndarray, np.ndarray]:
    """Of the first leg or pad."""
    return along.x[:, 0], along.lacks[:, 0]


def _bins(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Middles of bins of x (M,); mean and spread of y in each (M, 3)."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if len(x) < _FEWEST or np.ptp(x) <= 0.0:
        return None
    edges = np.linspace(x.min(), x.max(), _BINS + 1)
    index = np.clip(np.digitize(x, edges) - 1, 0, _BINS - 1)
    middles, rows = [], []
    for i in range(_BINS):
        mine = y[index == i]
        if len(mine) >= _FEWEST:
            middles.append(0.5 * (edges[i] + edges[i + 1]))
            rows.append((mine.mean(), *np.percentile(mine, _SPREAD)))
    return np.array(middles), np.array(rows)
