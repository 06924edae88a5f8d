"""Where the closed-loop gap lies: by channel, phase of motion and band."""

from __future__ import annotations

import numpy as np

from brace_drake.devices.twin import HIGHEST_HZ
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.isolation.phases import PHASES
from brace_drake.validation.shrinkage import RunComparison, channel_gaps

BANDS = ((0.0, 0.5), (0.5, 2.0), (2.0, 8.0), (8.0, 30.0), (30.0, 1e9))


def channel_budget(
    comparisons: list[RunComparison],
    channels: tuple[str, ...],
    floor: dict[str, float],
) -> list[dict]:
    """Rows of the budget by channel; shares of the excess add up to 1."""
    before = channel_gaps(comparisons, channels, "before")
    after = None
    if comparisons[0].after is not None:
        after = channel_gaps(comparisons, channels, "after")
    shares = _shares({n: g**2 - 1.0 for n, g in before.items()})
    return [
        {
            "channel": name,
            "unit": name.rsplit("_", 1)[-1],
            "floor": floor[name],
            "before": gap,
            "after": None if after is None else after[name],
            "share": shares[name],
        }
        for name, gap in before.items()
    ]


def phase_budget(
    comparisons: list[RunComparison], phases: list[np.ndarray]
) -> list[dict]:
    """Rows of the budget by phase of the motion."""
    rows, excess = [], {}
    for i, name in enumerate(PHASES):
        rows.append(_masked_row(name, comparisons, [p == i for p in phases]))
        excess[name] = rows[-1].pop("excess")
    shares = _shares(excess)
    return [
        {"phase": r.pop("name"), **r, "share": shares[n]}
        for n, r in zip(PHASES, rows, strict=True)
        if r["before"] is not None
    ]


def _masked_row(name, comparisons, masks):
    def mean(which):
        values = [
            c.normalised(which)[m]
            for c, m in zip(comparisons, masks, strict=True)
        ]
        values = np.concatenate([v.ravel() for v in values])
        return values if len(values) else None

    before = mean("before")
    row = {"name": name, "before": None, "after": None, "excess": 0.0}
    if before is None:
        return row
    row["before"] = float(np.sqrt(before.mean()))
    row["excess"] = float((before - 1.0).sum())
    if comparisons[0].after is not None:
        row["after"] = float(np.sqrt(max(0.0, mean("after").mean())))
    return row


def band_budget(comparisons: list[RunComparison], rate: float) -> list[dict]:
    """Rows of the budget by frequency band, against the floor's spectrum."""
    rows, excess = [], {}
    highest = min(HIGHEST_HZ, rate / 2.0)
    for low, high in BANDS:
        if low >= highest:
            continue
        before, count = _band_power(comparisons, "before", low, high, rate)
        row = {
            "from_Hz": low,
            "to_Hz": min(high, highest),
            "before": float(np.sqrt(before / max(count, 1))),
            "after": None,
        }
        if comparisons[0].after is not None:
            after, _ = _band_power(comparisons, "after", low, high, rate)
            row["after"] = float(np.sqrt(after / max(count, 1)))
        rows.append(row)
        excess[low] = before - count
    shares = _shares(excess)
    return [{**r, "share": shares[r["from_Hz"]]} for r in rows]


def _band_power(comparisons, which, low, high, rate):
    power, count = 0.0, 0
    for c in comparisons:
        residual = c.prepared.measured - getattr(c, which)
        frequency = np.fft.rfftfreq(len(residual), 1.0 / rate)
        inside = (frequency >= low) & (frequency < min(high, HIGHEST_HZ))
        used = c.prepared.used
        weights = full_weights(c.prepared, len(residual))
        transform = np.fft.rfft(residual, axis=0) * weights
        bins = transform[inside][:, used]
        values = 2 * bins.size
        if low == 0.0:
            values -= bins.shape[1]
        noise = c.dither * values if which == "after" else 0.0
        power += max(0.0, float(np.sum(np.abs(bins) ** 2)) - noise)
        count += values
    return power, count


def _shares(excess: dict) -> dict:
    positive = {k: max(0.0, v) for k, v in excess.items()}
    total = sum(positive.values())
    return {k: v / total if total > 0.0 else 0.0 for k, v in positive.items()}


def full_weights(prepared: PreparedRun, samples: int) -> np.ndarray:
    """Weights of a whole transform, 0 where frequencies do not count."""
    out = np.zeros((samples // 2 + 1, prepared.weights.shape[1]))
    out[: len(prepared.weights)] = prepared.weights
    return out
