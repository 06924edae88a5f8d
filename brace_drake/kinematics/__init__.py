"""Kinematics and statics of S stacked Stewart-Gough stages, from numbers.

Task coordinates X (6 S,) hold for each moving ring, bottom to top, its
position minus that at rest, W axes, m, then its rotation vector, rad. What
runs at every tick is compiled, in `brace_drake.laws.stages` and
`stage_poses`; here are the same laws for whole arrays.
"""

from brace_drake.kinematics.geometry import (
    BraceGeometry,
    circle_points,
    make_geometry,
)
from brace_drake.kinematics.motion import (
    find_task_coordinates,
    hold_at_rest,
    holding_leg_forces,
    leg_jacobian,
    leg_lengths,
    static_leg_forces,
    task_jacobian,
)
from brace_drake.kinematics.workspace import (
    StageMeasures,
    Workspace,
    measure_stages,
)

__all__ = [
    "BraceGeometry",
    "StageMeasures",
    "Workspace",
    "circle_points",
    "find_task_coordinates",
    "hold_at_rest",
    "holding_leg_forces",
    "leg_jacobian",
    "leg_lengths",
    "make_geometry",
    "measure_stages",
    "static_leg_forces",
    "task_jacobian",
]
