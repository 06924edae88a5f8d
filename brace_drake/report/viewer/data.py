"""Runs as the viewer's script reads them: small numbers in base64."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence

import numpy as np

from brace_drake.recording.columns import split_unit
from brace_drake.report.traces import RunTrace
from brace_drake.report.viewer.decimate import decimate
from brace_drake.report.words import channel_text, scale_of, times

# Channels of a run that can be looked at; the force and the worst others.
MOST_CHANNELS = 5
# Points of a trace, and of the traces of all runs together.
_MOST_POINTS, _ALL_POINTS, _LEAST_POINTS = 3000, 36000, 400
# Half-width of the noise floor's band, in standard deviations.
BAND = 2.0
_STEPS = 65000
_NOTHING = -32768


def encode_runs(traces: Sequence[RunTrace]) -> str:
    """JSON of all runs that is safe inside a script element.

    Values are whole numbers of 16 bits, a 65,000th of their range apart. The
    residual has a range of its own: it is not the difference of rounded
    values.
    """
    share = _ALL_POINTS // max(1, len(traces))
    most = min(_MOST_POINTS, max(_LEAST_POINTS, share))
    runs = [_encode_run(trace, most) for trace in traces]
    text = json.dumps(runs, allow_nan=False, separators=(",", ":"))
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text


def _encode_run(trace: RunTrace, most: int) -> dict:
    twins = trace.twins()
    channels = trace.ranked_channels()[:MOST_CHANNELS]
    columns = [
        values
        for c in channels
        for values in (
            trace.measured[:, c],
            *(twin[:, c] for _, twin in twins),
            *(trace.measured[:, c] - twin[:, c] for _, twin in twins),
        )
    ]
    if not columns:
        return {"name": trace.name, "time": _pack(trace.time_s), "channels": []}
    time, kept = decimate(trace.time_s, np.column_stack(columns), most)
    parts = np.split(kept, len(channels), axis=1)
    return {
        "name": trace.name,
        "time": _pack(time),
        "channels": [
            _encode_channel(trace, c, part)
            for c, part in zip(channels, parts, strict=True)
        ],
    }


def _encode_channel(trace: RunTrace, c: int, values: np.ndarray) -> dict:
    """One channel; columns are measured, each twin, each residual."""
    name, twins = trace.channels[c], trace.twins()
    unit = split_unit(name)[1]
    count = 1 + len(twins)
    factor, shown = scale_of(unit, [_largest(values[:, :count])])
    small, shown_small = scale_of(unit, [_largest(values[:, count:])])
    return {
        "label": channel_text(name),
        "unit": shown,
        "values": [_pack(v * factor) for v in values[:, :count].T],
        "residualUnit": shown_small,
        "residuals": [_pack(v * small) for v in values[:, count:].T],
        "band": float(BAND * trace.floor_rms[c] * small),
        "gaps": [
            times(float(trace.normalised_rms(twin)[c])) for _, twin in twins
        ],
        "twins": [kind for kind, _ in twins],
    }


def _largest(values: np.ndarray) -> float:
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max()) if finite.size else 0.0


def _pack(values: np.ndarray) -> dict:
    """Offset, step and base64 of little-endian 16-bit numbers."""
    finite = values[np.isfinite(values)]
    low, high = (finite.min(), finite.max()) if finite.size else (0.0, 0.0)
    step = float(high - low) / _STEPS or 1.0
    middle = 0.5 * float(low + high)
    with np.errstate(invalid="ignore"):
        steps = np.round((values - middle) / step)
    whole = np.where(np.isfinite(values), steps, _NOTHING).astype("<i2")
    data = base64.b64encode(whole.tobytes()).decode("ascii")
    return {"middle": middle, "step": step, "data": data}
