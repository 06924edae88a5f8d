"""Tables and figures of experiments: columns, intervals, CSV, Markdown, PNG."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from brace_drake.core.csv_text import csv_text

_DRAWS = 2000


class Column(NamedTuple):
    """A measure, its column, its title with the unit, its factor from SI."""

    measure: str
    name: str
    title: str
    factor: float


# Root mean square errors, those of the paper's Table 1.
TABLE_1 = (
    Column("y_rms", "y_rmse_mm", "y, mm", 1e3),
    Column("vy_rms", "vy_rmse_mm_s", "y', mm/s", 1e3),
    Column("x_rms", "x_rmse_mm", "x, mm", 1e3),
    Column("z_rms", "z_rmse_mm", "z, mm", 1e3),
    Column("force_rms", "force_rmse_N", "F_y, N", 1.0),
)
PEAK_FORCE = Column("peak_force", "peak_force_N", "peak F_y, N", 1.0)
STIFFNESS = Column("stiffness", "stiffness_N_m", "K, N/m", 1.0)


@dataclass(frozen=True)
class PaperRow:
    """A row of the paper's Table 1, SI units."""

    y_rms: float
    vy_rms: float
    x_rms: float
    z_rms: float
    force_rms: float


TABLE_1_PIC = PaperRow(0.31054e-3, 0.95586e-3, 0.072539e-3, 0.067516e-3, 0.1526)
TABLE_1_RLPIC = PaperRow(
    0.15245e-3, 0.2234e-3, 0.054103e-3, 0.049757e-3, 0.0163
)


def cells_of(columns: Iterable[Column], measured) -> dict[str, float]:
    """What was measured by column, in the column's unit, where it was."""
    return {
        c.name: c.factor * getattr(measured, c.measure)
        for c in columns
        if hasattr(measured, c.measure)
    }


@dataclass(frozen=True)
class Spread:
    """A number with its 95 % interval; nan where there is none."""

    value: float
    lower: float = np.nan
    upper: float = np.nan


def student_interval(values: Sequence[float]) -> Spread:
    """Mean with Student's interval.

    There is none for a single value, or where one is infinite.
    """
    values = np.asarray(values, dtype=float)
    mean, n = float(values.mean()), len(values)
    if n < 2 or not np.isfinite(mean):
        return Spread(mean)
    half = float(scipy.stats.t.ppf(0.975, n - 1) * values.std(ddof=1) / n**0.5)
    return Spread(mean, mean - half, mean + half)


def median_interval(values: np.ndarray, seed: int = 0) -> Spread:
    """Median with the bootstrap's percentiles over subjects.

    Args:
        values: Of each subject, or of seeds and subjects: then subjects are
            drawn with all their seeds, and the medians of seeds averaged.
        seed: Of the bootstrap.
    """
    values = np.atleast_2d(values)
    count = values.shape[1]
    drawn = np.random.default_rng(seed).integers(count, size=(_DRAWS, count))
    medians = np.median(values[:, drawn], axis=2).mean(axis=0)
    # Between a number and an infinite one there is nothing to interpolate.
    how = "linear" if np.isfinite(medians).all() else "nearest"
    low, high = np.percentile(medians, [2.5, 97.5], method=how)
    value = float(np.median(values, axis=1).mean())
    return Spread(value, float(low), float(high))


def share_interval(events: np.ndarray) -> Spread:
    """Share of subjects with an event, Wilson's interval over subjects.

    Args:
        events: Bool, (subjects,) or (seeds, subjects); means of seeds count.
    """
    p = np.atleast_2d(events).mean(axis=0)
    n, share, z = len(p), float(p.mean()), float(scipy.stats.norm.ppf(0.975))
    centre = (share + z * z / (2 * n)) / (1 + z * z / n)
    half = z * np.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
    half /= 1 + z * z / n
    low, high = max(0.0, centre - half), min(1.0, centre + half)
    return Spread(share, float(low), float(high))


def format_csv(rows: Sequence[dict], digits: int = 6) -> str:
    """Rows as CSV; an interval takes three columns, no number none."""
    flat = [_flatten(row, digits) for row in rows]
    columns = list(dict.fromkeys(k for row in flat for k in row))
    return csv_text(columns, flat)


def _flatten(row: dict, digits: int) -> dict:
    flat = {}
    for key, value in row.items():
        if isinstance(value, Spread):
            flat[key] = value.value
            flat[f"{key}_lower95"] = value.lower
            flat[f"{key}_upper95"] = value.upper
        else:
            flat[key] = value
    for key, value in flat.items():
        if isinstance(value, bool):
            flat[key] = int(value)
        elif isinstance(value, float):
            flat[key] = "" if math.isnan(value) else f"{value:.{digits}g}"
    return flat


def format_table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table without a line's end; titles with a comma, of numbers
    with a unit, are aligned to the right.
    """
    rules = ["---:" if "," in title else "---" for title in titles]
    lines = [f"| {' | '.join(cells)} |" for cells in (titles, *rows)]
    return "\n".join([lines[0], f"|{'|'.join(rules)}|", *lines[1:]])


def to_png(figure) -> bytes:
    """A figure as the bytes of a PNG file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=160, metadata={"Software": None})
    return buffer.getvalue()
