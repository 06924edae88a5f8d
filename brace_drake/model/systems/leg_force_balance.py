"""What the legs leave for the torso, for a supervisor of force sensors."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.kinematics import BraceGeometry
from brace_drake.laws import stages
from brace_drake.laws.loop.force_left import calc_forces_left

# Places in a velocity [v; w] of task coordinates.
_ROTATION_FIRST = [3, 4, 5, 0, 1, 2]


class LegForceBalance(LeafSystem):
    """Forces on the torso that commands and poses tell, without a sensor.

    The law is `laws.loop.force_left.calc_forces_left`, of n moving rings.

    Input ports:
        estimate: X, X', and the filtered force (18n,), of a controller.
        leg_command: What is held (6n,), N.

    Output ports:
        force: Of each ring on the torso in W (3n,), N.
    """

    def __init__(
        self, geometry: BraceGeometry, viscous: np.ndarray, weights: np.ndarray
    ):
        super().__init__()
        n = geometry.num_stages
        self._geometry, self._viscous = geometry, viscous
        self._weights = np.asarray(weights, dtype=float)
        self._estimate = self.DeclareVectorInputPort("estimate", 18 * n)
        self._command = self.DeclareVectorInputPort("leg_command", 6 * n)
        self.DeclareVectorOutputPort("force", BasicVector(3 * n), self._Calc)

    def _Calc(self, context: Context, output: BasicVector) -> None:
        geometry, n = self._geometry, self._geometry.num_stages
        estimate = self._estimate.Eval(context)
        poses, forces = np.empty((n, 7)), np.empty(3 * n)
        stages.place_rings(estimate[0 : 6 * n], geometry.rest, poses)
        V = estimate[6 * n : 12 * n].reshape((n, 6))
        calc_forces_left(
            poses, V.take(_ROTATION_FIRST, axis=1),
            self._command.Eval(context), self._viscous, self._weights,
            geometry.lower, geometry.upper, forces,
        )  # fmt: skip
        output.SetFromVector(forces)
