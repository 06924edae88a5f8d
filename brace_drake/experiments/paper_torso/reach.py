"""What velocity a force through the pad can go with, whatever the torso does.

A torso of mass m behind a pad of stiffness k and damping c, at the angular
frequency w: a force F moves the torso with F / (i w m) and compresses the pad
with i w F / (k + i w c). The ring's velocity is the sum of both,

    v / F = 1 / (i w m) + i w / (k + i w c).

No controller and no lean is in it. RMS errors of velocity and force in the
ratio v / F need motion at frequencies where the law has this ratio or more.
"""

from __future__ import annotations

import numpy as np

from brace_drake.experiments.tables import PaperRow


def rate_per_force(
    omega: np.ndarray, mass: float, stiffness: float, damping: float
) -> np.ndarray:
    """|v / F| of the ring at angular frequencies, m/s for each N."""
    s = 1j * np.asarray(omega, dtype=float)
    return np.abs(1.0 / (s * mass) + s / (stiffness + s * damping))


def frequencies_of(
    row: PaperRow, mass: float, stiffness: float, damping: float
) -> tuple[float, float]:
    """Between which frequencies a row's velocity is more than its force moves.

    Args:
        row: Of the paper's table.
        mass, stiffness, damping: kg, N/m, N s/m.

    Returns:
        rad/s: the motion is slower than the first, or faster than the second
        (inf: no motion is fast enough).
    """
    omega = np.geomspace(0.01, 1e5, 200_000)
    ratio = rate_per_force(omega, mass, stiffness, damping)
    enough = ratio >= row.vy_rms / row.force_rms
    least = int(np.argmin(ratio))
    slow = omega[:least][enough[:least]]
    fast = omega[least:][enough[least:]]
    return (
        float(slow[-1]) if len(slow) else 0.0,
        float(fast[0]) if len(fast) else np.inf,
    )


def inertial_force_rms(mass: float, distance: float, duration: float) -> float:
    """RMS of m a about its final value along the cubic of a push, N.

    a goes in a line from 6 d / T^2 to -6 d / T^2, so that the distance from
    its end has the RMS 12 d / T^2 / sqrt(3).
    """
    return mass * 12.0 * abs(distance) / duration**2 / np.sqrt(3.0)
