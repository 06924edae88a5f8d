"""Columns that tables of runs share."""

from __future__ import annotations

from typing import NamedTuple


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
