"""Where the closed-loop gap lies: by channel, phase of the motion and band.

Rows by one of them alone, and by all three at once: a residual is cut into
bands by its spectrum without shifting it in time, then into phases by time, and
in each cell its power is compared with what noise alone has there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.core.block_bootstrap import interval_of, pieces_of
from brace_drake.devices.twin import HIGHEST_HZ
from brace_drake.identification.gap import RunComparison, is_repaired, rms_gap
from brace_drake.identification.whitening import (
    Band,
    band_in_frequency,
    band_in_time,
)
from brace_drake.isolation.phases import PHASES

_EDGES_HZ = (0.0, 0.5, 2.0, 8.0, 30.0)
# Cells with less than this share of the gap are left out.
_LEAST_SHARE = 0.002


def bands_up_to(rate: float) -> list[Band]:
    """Limits of the bands of recordings at a rate, Hz."""
    highest = min(HIGHEST_HZ, rate / 2.0)
    low = [edge for edge in _EDGES_HZ if edge < highest]
    return list(zip(low, [*low[1:], highest], strict=True))


def channel_budget(
    compared: Sequence[RunComparison], channels: Sequence[str]
) -> list[dict]:
    """Rows of the budget by channel; shares of the excess add up to 1."""
    floor = compared[-1].prepared.floor.rms
    rows = []
    for c, name in enumerate(channels):
        before = rms_gap(compared, "before", c)
        if before is None:
            continue
        row = {"channel": name, "unit": name.rsplit("_", 1)[-1]}
        after = rms_gap(compared, "after", c) if is_repaired(compared) else None
        row |= {"floor": floor[c], "before": before, "after": after}
        rows.append(row | {"share": before**2 - 1.0})
    return _with_shares(rows)


def phase_budget(
    compared: Sequence[RunComparison], phases: Sequence[np.ndarray]
) -> list[dict]:
    """Rows of the budget by phase of the motion."""
    squares = {
        which: np.concatenate([c.squares(which) for c in compared])
        for which in ("before", "after")
        if which == "before" or is_repaired(compared)
    }
    phase, rows = np.concatenate(phases), []
    for i, name in enumerate(PHASES):
        means: dict[str, float | None] = {"before": None, "after": None}
        for which, values in squares.items():
            inside = values[phase == i]
            inside = inside[~np.isnan(inside)]
            if len(inside):
                mean = float(inside.mean())
                means[which] = float(np.sqrt(max(0.0, mean)))
                if which == "before":
                    excess = float((inside - 1.0).sum())
        if means["before"] is not None:
            rows.append({"phase": name, **means, "share": excess})
    return _with_shares(rows)


def band_budget(compared: Sequence[RunComparison], rate: float) -> list[dict]:
    """Rows of the budget by frequency band, against the floor's spectrum."""
    rows = []
    for band in bands_up_to(rate):
        row = {"from_Hz": band[0], "to_Hz": band[1], "after": None}
        for which in ("before", "after"):
            if which == "after" and not is_repaired(compared):
                continue
            power, count = 0.0, 0.0
            for c in compared:
                residual = c.prepared.measured - getattr(c, which)
                transform, inside = band_in_frequency(
                    c.prepared, residual, band, rate
                )
                size = inside.sum() * c.prepared.used.sum()
                noise = c.dither * size if which == "after" else 0.0
                square = float(np.sum(transform**2))
                power, count = power + max(0.0, square - noise), count + size
            row[which] = float(np.sqrt(power / max(count, 1.0)))
            if which == "before":
                row["share"] = power - count
        rows.append(row)
    return _with_shares(rows)


def _with_shares(rows: list[dict]) -> list[dict]:
    """Rows whose `share` is an excess, with its part of all that is above 0."""
    total = sum(max(0.0, row["share"]) for row in rows)
    for row in rows:
        excess = max(0.0, row["share"])
        row["share"] = excess / total if total > 0.0 else 0.0
    return rows


def gap_cells(
    compared: Sequence[RunComparison],
    phases: Sequence[np.ndarray],
    channels: Sequence[str],
    rate: float,
    seed: int,
) -> list[dict]:
    """Cells of the gap before repair, largest share first.

    Args:
        compared: Runs with their residuals.
        phases: Of each run, an index into PHASES for each sample (N,).
        channels: Names of all columns.
        rate: Hz.
        seed: Of the bootstrap over pieces of time.

    Returns:
        Rows with share of all power above noise, normalised RMS (1 is noise),
        and the 95 % interval of the share; cells without content left out.
    """
    bands = bands_up_to(rate)
    # Power and what noise has of it (pieces, 2, C, P, B).
    cells = np.concatenate(
        [
            _cells_of_run(c, phase, bands, rate)
            for c, phase in zip(compared, phases, strict=True)
        ]
    )

    def shares_of(weights):
        power, count = np.tensordot(weights, cells, 1)
        # A sum of n squares of noise deviates from n by sqrt(2 n).
        spread = 4.0 * np.sqrt(2.0 * count)
        excess = np.where(power - count > spread, power - count, 0.0)
        total = excess.sum()
        return excess / total if total > 0.0 else excess

    shares = shares_of(np.ones(len(cells)))
    low, high = interval_of(shares_of, len(cells), [seed, 41])
    power, count = cells.sum(axis=0)
    rows = []
    for at in np.argsort(shares, axis=None)[::-1]:
        cell = c, p, b = np.unravel_index(at, shares.shape)
        if shares[cell] < _LEAST_SHARE:
            break
        rows.append(
            {
                "channel": channels[c],
                "phase": PHASES[p],
                "from_Hz": bands[b][0],
                "to_Hz": bands[b][1],
                "share": float(shares[cell]),
                "normalised_rms": float(np.sqrt(power[cell] / count[cell])),
                "lower95": float(low[cell]),
                "upper95": float(high[cell]),
            }
        )
    return rows


def _cells_of_run(
    c: RunComparison, phase: np.ndarray, bands: Sequence[Band], rate: float
) -> np.ndarray:
    """Power and what noise has of it, piece by piece (n, 2, C, P, B)."""
    run, used = c.prepared.run, c.prepared.used.astype(float)
    masks = (phase[:, None] == np.arange(len(PHASES))).astype(float)
    masks = pieces_of(run, masks)
    out = np.zeros((len(masks), 2, len(used), len(PHASES), len(bands)))
    residual = c.prepared.measured - c.before
    for b, band in enumerate(bands):
        series, level = band_in_time(c.prepared, residual, band, rate)
        for i, squares in enumerate(pieces_of(run, series**2)):
            out[i, 0, :, :, b] = squares.T @ masks[i]
            out[i, 1, :, :, b] = level * np.outer(used, masks[i].sum(axis=0))
    return out
