"""Forces that a run begins with: the legs hold the ring at rest."""

import numpy as np

from brace_drake.laws.legs import calc_leg_kinematics


def holding_forces(numbers) -> np.ndarray:
    """Forces of the legs J^-T w that carry the ring's weight (6,), N.

    Args:
        numbers: Of the bench.
    """
    lengths, J = np.empty(6), np.empty((6, 6))
    calc_leg_kinematics(
        numbers.rest, np.eye(3), numbers.p_WB, numbers.p_RT, lengths, J
    )
    weight = np.array([0.0, 0.0, numbers.ring[4], 0.0, 0.0, 0.0])
    return np.linalg.solve(J.T, weight)
