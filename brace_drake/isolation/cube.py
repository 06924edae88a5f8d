"""The gap by channel, phase of the motion and frequency band at once.

A residual is cut into bands by its spectrum without shifting it in time, then
into phases of the motion by time. In each cell its power is compared with what
noise alone has there: the same weights that make noise white, so that a cell
of n values holds n on average when nothing is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.twin import HIGHEST_HZ
from brace_drake.isolation.budget import BANDS, full_weights
from brace_drake.validation.shrinkage import RunComparison

# Cells with less than this share of the gap are left out.
_LEAST_SHARE = 0.002
_RESAMPLES = 300
_PIECE_S = 1.0


def gap_cube(
    comparisons: Sequence[RunComparison],
    phases: Sequence[np.ndarray],
    phase_names: Sequence[str],
    channels: Sequence[str],
    rate: float,
    seed: int,
) -> list[dict]:
    """Cells of the gap before repair, largest share first.

    Args:
        comparisons: Runs with their residuals.
        phases: Of each run, an index into `phase_names` for each sample (N,).
        phase_names: Names.
        channels: Names of all columns.
        rate: Hz.
        seed: Of the bootstrap over pieces of time.

    Returns:
        Rows with share of all power above noise, normalised RMS (1 is noise),
        and the 95 % interval of the share; cells without content left out.
    """
    highest = min(HIGHEST_HZ, rate / 2.0)
    bands = [b for b in BANDS if b[0] < highest]
    power, count = _pieces(comparisons, phases, len(phase_names), bands, rate)
    shares = _shares(power.sum(axis=0), count.sum(axis=0))
    low, high = _interval(power, count, seed)
    rows = []
    for at in np.argsort(shares, axis=None)[::-1]:
        c, p, b = np.unravel_index(at, shares.shape)
        if shares[c, p, b] < _LEAST_SHARE:
            break
        mean = power[:, c, p, b].sum() / count[:, c, p, b].sum()
        rows.append(
            {
                "channel": channels[c],
                "phase": phase_names[p],
                "from_Hz": bands[b][0],
                "to_Hz": min(bands[b][1], highest),
                "share": float(shares[c, p, b]),
                "normalised_rms": float(np.sqrt(mean)),
                "lower95": float(min(low[c, p, b], shares[c, p, b])),
                "upper95": float(max(high[c, p, b], shares[c, p, b])),
            }
        )
    return rows


def band_series(
    residual: np.ndarray, weights: np.ndarray, low: float, high: float, rate
) -> tuple[np.ndarray, float]:
    """One band of a residual, whitened, in time.

    Args:
        residual: (N, C).
        weights: See `NoiseFloor.weights` (N // 2 + 1, C).
        low, high: Limits of the band, Hz.
        rate: Hz.

    Returns:
        The series (N, C), and the mean square that noise alone has in it.
    """
    samples = len(residual)
    frequency = np.fft.rfftfreq(samples, 1.0 / rate)
    inside = (frequency >= low) & (frequency < min(high, HIGHEST_HZ))
    transform = np.fft.rfft(residual, axis=0) * weights
    transform[~inside] = 0.0
    # Weights count both sides of the spectrum, the transform back does too.
    sides = np.full(len(frequency), 2.0)
    sides[0] = 1.0
    if samples % 2 == 0:
        sides[-1] = 1.0
    series = np.fft.irfft(
        transform / np.sqrt(sides)[:, None], samples, axis=0, norm="ortho"
    )
    return series, float(sides[inside].sum() / samples)


def _pieces(comparisons, phases, num_phases, bands, rate):
    """Power and what noise has of it, piece by piece (n, C, P, B)."""
    power, count = [], []
    for comparison, phase in zip(comparisons, phases, strict=True):
        prepared = comparison.prepared
        residual = prepared.measured - comparison.before
        samples, channels = residual.shape
        weights = full_weights(prepared, samples)
        length = max(1, round(_PIECE_S * rate))
        starts = np.arange(0, samples, length)
        shape = (len(starts), channels, num_phases, len(bands))
        mine, noise = np.zeros(shape), np.zeros(shape)
        masks = phase[:, None] == np.arange(num_phases)
        in_piece = np.add.reduceat(masks.astype(float), starts, axis=0)
        for b, (low, high) in enumerate(bands):
            series, level = band_series(residual, weights, low, high, rate)
            squares = series**2
            for p in range(num_phases):
                cut = squares * masks[:, [p]]
                mine[:, :, p, b] = np.add.reduceat(cut, starts, axis=0)
                expected = level * in_piece[:, [p]] * prepared.used
                noise[:, :, p, b] = expected
        power.append(mine)
        count.append(noise)
    return np.concatenate(power), np.concatenate(count)


def _shares(power: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Shares of power above noise; cells within the noise's spread have none.

    A sum of n squares of noise strays from n by sqrt(2 n).
    """
    spread = 4.0 * np.sqrt(2.0 * count)
    excess = np.where(power - count > spread, power - count, 0.0)
    total = excess.sum()
    return excess / total if total > 0.0 else excess


def _interval(power, count, seed):
    generator = np.random.default_rng([seed, 41])
    n, draws = len(power), []
    shape = power.shape[1:]
    flat_power = power.reshape(n, -1)
    flat_count = count.reshape(n, -1)
    for _ in range(_RESAMPLES):
        times = generator.multinomial(n, np.full(n, 1.0 / n)).astype(float)
        draws.append(_shares(times @ flat_power, times @ flat_count))
    low, high = np.quantile(draws, [0.025, 0.975], axis=0)
    return low.reshape(shape), high.reshape(shape)
