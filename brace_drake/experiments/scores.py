"""What Table 1 and its neighbours say of one push, and of many."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from scipy import stats

from brace_drake.experiments.measures import rms
from brace_drake.experiments.rollouts import Arena, Rollout

_START_S = 1.0
# Of the range, on a linear scale: nearer than this counts as its end.
_AT_BOUND = 0.01
_DRAWS = 2000


@dataclass(frozen=True)
class Score:
    """Measures of one push along its coordinate; rms of desired minus actual.

    Of a push that has failed errors and forces are infinite, and there is no
    stiffness (nan): what it did until then is no measure of a whole push.

    Attributes:
        y_rms, vy_rms: Position, m, and velocity, m/s, along the push.
        x_rms, z_rms: Position across it, m.
        force_rms: Force about its own final value, N, as the paper has it.
        peak_force: Greatest force, N.
        start_rate: Greatest error of the velocity in the first second, m/s.
        y_end: Error of the position at the end, m.
        stiffness, stiffness_low, stiffness_high: In use over the second half
            of the push: mean, least and most, N/m.
        at_upper: Whether that mean is at the upper end of its range.
        total: Return.
        over_force: Whether the force passed F_max of the reward.
        broke: Whether a limit that ends an episode was passed, or worse.
    """

    y_rms: float
    vy_rms: float
    x_rms: float
    z_rms: float
    force_rms: float
    peak_force: float
    start_rate: float
    y_end: float
    stiffness: float
    stiffness_low: float
    stiffness_high: float
    at_upper: bool
    total: float
    over_force: bool
    broke: bool

    @property
    def violates(self) -> bool:
        """Whether F_max or a limit was passed."""
        return self.over_force or self.broke


FIELDS = tuple(f.name for f in fields(Score))


def score_rollout(arena: Arena, rollout: Rollout) -> Score:
    """Measures of a push."""
    if rollout.failed:
        return _FAILED
    i = arena.pushed
    base = 6 * (i // 6)
    error = rollout.desired - rollout.position
    rate = (rollout.desired_rate - rollout.rate)[:, i]
    force = rollout.force[:, i]
    early = rollout.time <= _START_S
    peak = float(np.abs(force).max())
    chosen = int(np.flatnonzero(np.flatnonzero(arena.selected) == i)[0])
    settled = rollout.stiffness[len(rollout.stiffness) // 2 :, chosen]
    mean, law = float(settled.mean()), arena.law
    return Score(
        y_rms=rms(error[:, i]),
        vy_rms=rms(rate),
        x_rms=rms(error[:, base]),
        z_rms=rms(error[:, base + 2]),
        force_rms=rms(force[-1] - force),
        peak_force=peak,
        start_rate=float(np.abs(rate[early]).max()),
        y_end=float(abs(error[-1, i])),
        stiffness=mean,
        stiffness_low=float(settled.min()),
        stiffness_high=float(settled.max()),
        at_upper=bool(law.upper - mean < _AT_BOUND * (law.upper - law.lower)),
        total=rollout.total,
        over_force=bool(peak > arena.task.reward.force_limit[i]),
        broke=bool(rollout.cause),
    )


_FAILED = Score(
    **dict.fromkeys(
        (
            "y_rms", "vy_rms", "x_rms", "z_rms", "force_rms", "peak_force",
            "start_rate", "y_end",
        ),
        np.inf,
    ),
    **dict.fromkeys(
        ("stiffness", "stiffness_low", "stiffness_high"), np.nan
    ),
    at_upper=False,
    total=-np.inf,
    over_force=True,
    broke=True,
)  # fmt: skip


@dataclass(frozen=True)
class Spread:
    """A number with its 95 % interval; nan where there is none."""

    value: float
    lower: float = np.nan
    upper: float = np.nan


def over_seeds(values: np.ndarray) -> Spread:
    """Mean over seeds with Student's interval.

    There is none for a single one, or where one is infinite.
    """
    values = np.asarray(values, dtype=float)
    mean, n = float(values.mean()), len(values)
    if n < 2 or not np.isfinite(mean):
        return Spread(mean)
    half = float(stats.t.ppf(0.975, n - 1) * values.std(ddof=1) / n**0.5)
    return Spread(mean, mean - half, mean + half)


def median_over(values: np.ndarray, seed: int = 0) -> Spread:
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


def share_of(events: np.ndarray) -> Spread:
    """Share of subjects with an event, Wilson's interval over subjects.

    Args:
        events: Bool, (subjects,) or (seeds, subjects); means of seeds count.
    """
    p = np.atleast_2d(events).mean(axis=0)
    n, share, z = len(p), float(p.mean()), float(stats.norm.ppf(0.975))
    centre = (share + z * z / (2 * n)) / (1 + z * z / n)
    half = z * np.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
    half /= 1 + z * z / n
    low, high = max(0.0, centre - half), min(1.0, centre + half)
    return Spread(share, float(low), float(high))
