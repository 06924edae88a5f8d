"""The bench for its user: hand it a motion, it hands back a recording."""

from __future__ import annotations

import numpy as np

from brace_drake.withheld.stand_in import numbers
from brace_drake.withheld.stand_in.chance import draw
from brace_drake.withheld.stand_in.flaws import Flaws
from brace_drake.withheld.stand_in.numbers import Subject
from brace_drake.withheld.stand_in.recorder import record

COLUMNS = (
    *(f"leg{k}_force_command_N" for k in range(1, 7)),
    *(f"leg{k}_length_m" for k in range(1, 7)),
    *(f"ring2_force_{axis}_N" for axis in "xyz"),
    *(f"torso_{axis}_m" for axis in "xyz"),
    "ring2_y_virtual_m",
)
REFERENCE = (
    "ring2_y_desired_m",
    "ring2_vy_desired_m_s",
    "ring2_ay_desired_m_s2",
)


def run_bench(
    wanted: np.ndarray,
    contact: bool,
    subject: Subject,
    flaws: Flaws,
    rng: np.random.Generator,
    noise: bool = True,
    steps: int = numbers.STEPS,
) -> np.ndarray:
    """Records a run at 200 Hz.

    Args:
        wanted: Reference y, y', y'' at 1 kHz, (n, 3), SI units.
        contact: Whether the torso is there.
        subject: The wearer.
        flaws: What is wrong.
        rng: Of everything random; the same one gives the same run.
        noise: False for ideal instruments, which do not round either.
        steps: Of the integration in a tick.

    Returns:
        (n / 5, 19) in the order of COLUMNS.
    """
    nominal = np.stack([numbers.lower_joints(), numbers.upper_joints()])
    real = nominal + np.array([flaws.ring.lower, flaws.ring.upper])
    run_rng, marker_rng = rng.spawn(2)
    log = record(
        np.ascontiguousarray(wanted),
        contact,
        subject,
        flaws,
        real,
        nominal,
        noise,
        steps,
        draw(run_rng, len(wanted), flaws, noise),
    )
    if noise:
        log[:, 15:18] += numbers.MARKER_NOISE * marker_rng.standard_normal(
            (len(log), 3)
        )
    return log
