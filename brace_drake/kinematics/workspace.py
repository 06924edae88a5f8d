"""How far a brace is from the ends of its strokes and from singularities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import KinematicsError
from brace_drake.kinematics.geometry import BraceGeometry


@dataclass(frozen=True)
class StageMeasures:
    """A stage at a pose.

    J is made comparable in force and torque by a characteristic length L, the
    radius of the upper joints: its columns for rotation are divided by L, so
    that all its entries are numbers without unit.

    Attributes:
        singular_value: Smallest of J: metres of leg for a metre of ring in the
            direction that the legs hold worst; 0 at a singularity.
        condition_number: Largest over smallest singular value.
        stroke_use: Largest |l - l_rest| over half of the stroke; 1 is the end.
        leg: The leg of that stage that uses its stroke most, 1 to 6.
    """

    singular_value: float
    condition_number: float
    stroke_use: float
    leg: int


@dataclass(frozen=True)
class Workspace:
    """Poses that a brace may take, seen stage by stage.

    Attributes:
        stroke: Of a leg, centred on its length at rest, m.
        singular_value: Least one allowed, see StageMeasures.
    """

    stroke: float
    singular_value: float

    def check(self, geometry: BraceGeometry, X: np.ndarray) -> None:
        """Checks task coordinates X (6 S,).

        Raises:
            KinematicsError: X lies outside; one line with the stage, what it
                exceeds, by how much and what is allowed.
        """
        for i in range(geometry.num_stages):
            self.check_stage(geometry, X, i)

    def check_stage(
        self, geometry: BraceGeometry, X: np.ndarray, i: int
    ) -> None:
        """As `check`, of the stage of index i alone."""
        m, half = measure_stages(geometry, X, self.stroke)[i], self.stroke / 2
        at = f"stage {i + 1} from below"
        if not m.stroke_use <= 1.0:
            raise KinematicsError(
                f"{at}: leg {m.leg} is {m.stroke_use * half:.4g} m from its"
                f" length at rest; allowed: up to {half:.4g} m, half its stroke"
            )
        if not m.singular_value >= self.singular_value:
            raise KinematicsError(
                f"{at}: smallest singular value {m.singular_value:.3g};"
                f" allowed: {self.singular_value:.3g} or more"
            )

    def holds(self, geometry: BraceGeometry, X: np.ndarray) -> bool:
        """Whether X (6 S,) lies within."""
        try:
            self.check(geometry, X)
        except KinematicsError:
            return False
        return True


def measure_stages(
    geometry: BraceGeometry, X: np.ndarray, stroke: float
) -> list[StageMeasures]:
    """Measures of each stage at task coordinates X (6 S,), bottom to top.

    A stage whose lengths are beyond floating point is singular.
    """
    lengths, J, _ = geometry.at(X)
    change = np.abs(lengths - geometry.rest_lengths).reshape(-1, 6)
    measures = []
    for own, at, upper in zip(change, J, geometry.upper, strict=True):
        L = np.linalg.norm(upper, axis=1).max()
        scaled = at / np.array([1.0, 1.0, 1.0, L, L, L])
        values = np.zeros(6)
        if np.isfinite(scaled).all():
            values = np.linalg.svd(scaled, compute_uv=False)
        condition = values[0] / values[-1] if values[-1] > 0.0 else np.inf
        measures.append(
            StageMeasures(
                float(values[-1]),
                float(condition),
                float(own.max() / (0.5 * stroke)),
                int(own.argmax()) + 1,
            )
        )
    return measures
