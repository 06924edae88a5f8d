"""What each reading of equation (2) recovers when k and c are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.identification.subject.nn_regression import (
    DISCRETISATIONS,
    NnContactEstimate,
    fit_contact_nn,
)

_DURATION_S = 12.0
_DEPTH_M = -0.010
_RIPPLE_M = 0.0005
_FREQUENCIES_HZ = (0.4, 0.9, 1.7)


@dataclass(frozen=True)
class ComparisonRow:
    """One record, one discretisation, against the truth.

    Attributes:
        mass: m of the record, kg.
        interval_s: sampling interval, s.
        estimate: what the regression returned.
        stiffness_error: (estimated k - true k) / true k.
        damping_error: (estimated c - true c) / true c.
    """

    mass: float
    interval_s: float
    estimate: NnContactEstimate
    stiffness_error: float
    damping_error: float


def push_record(
    time_s: np.ndarray, stiffness: float, damping: float, mass: float
) -> tuple[np.ndarray, np.ndarray]:
    """Law: F = m y'' + c y' + k y for a given y, without integration error.

    y is the paper's cubic push, -10 mm in 12 s, plus three sines of 0.5 mm
    at 0.4, 0.9 and 1.7 Hz: the push alone, at 1.25 mm/s, says next to nothing
    of c. Since y is a closed form the force is one too.

    Args:
        time_s: shape (N,), s.
        stiffness: k, N/m.
        damping: c, N s/m.
        mass: m, kg.

    Returns:
        Displacement, shape (N,), m, and force, shape (N,), N.

    Source: equation (1) and section 4.2 of the paper.
    """
    tau = np.asarray(time_s, dtype=float) / _DURATION_S
    y = _DEPTH_M * (3.0 * tau**2 - 2.0 * tau**3)
    dy = _DEPTH_M * 6.0 * (tau - tau**2) / _DURATION_S
    ddy = _DEPTH_M * 6.0 * (1.0 - 2.0 * tau) / _DURATION_S**2
    for frequency in _FREQUENCIES_HZ:
        w = 2.0 * np.pi * frequency
        y = y + _RIPPLE_M * np.sin(w * time_s)
        dy = dy + _RIPPLE_M * w * np.cos(w * time_s)
        ddy = ddy - _RIPPLE_M * w**2 * np.sin(w * time_s)
    return y, mass * ddy + damping * dy + stiffness * y


def compare_discretisations(
    *,
    stiffness: float = 6400.0,
    damping: float = 150.0,
    masses: Sequence[float] = (40.0, 0.0),
    intervals_s: Sequence[float] = (0.05, 0.01, 0.002),
    displacement_noise_m: float = 0.0,
    force_noise_N: float = 0.0,
    seed: int = 0,
) -> tuple[ComparisonRow, ...]:
    """Fits both discretisations to `push_record`; one row per case.

    Args:
        stiffness: true k, N/m.
        damping: true c, N s/m.
        masses: values of m, kg; 0 is the massless contact.
        intervals_s: sampling intervals, s.
        displacement_noise_m: one standard deviation of white noise on y, m.
        force_noise_N: one standard deviation of white noise on F, N.
        seed: seed of the noise and of the network's first weights.

    Returns:
        Rows in the order mass, interval, discretisation.
    """
    generator = np.random.default_rng(seed)
    rows = []
    for mass in masses:
        for interval_s in intervals_s:
            time_s = np.arange(0.0, _DURATION_S, interval_s)
            y, force = push_record(time_s, stiffness, damping, mass)
            noise = generator.standard_normal((2, time_s.size))
            y = y + displacement_noise_m * noise[0]
            force = force + force_noise_N * noise[1]
            for discretisation in DISCRETISATIONS:
                estimate = fit_contact_nn(
                    time_s,
                    y,
                    force,
                    mass,
                    discretisation=discretisation,
                    seed=seed,
                )
                rows.append(
                    ComparisonRow(
                        mass,
                        interval_s,
                        estimate,
                        estimate.stiffness / stiffness - 1.0,
                        estimate.damping / damping - 1.0,
                    )
                )
    return tuple(rows)
