"""An evaluation as CSV: the paper's Table 1, a summary, every push."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np

from brace_drake.core.output import WriteText
from brace_drake.experiments.evaluate import Evaluation
from brace_drake.experiments.rollouts import TaskScore
from brace_drake.experiments.tables import (
    PEAK_FORCE,
    STIFFNESS,
    TABLE_1,
    TABLE_1_PIC,
    TABLE_1_RLPIC,
    Column,
    cells_of,
    format_csv,
    median_interval,
    share_interval,
    student_interval,
)

COLUMNS = (
    *TABLE_1,
    Column("start_rate", "start_rate_error_mm_s", "start of y', mm/s", 1e3),
    PEAK_FORCE,
    STIFFNESS,
    Column("stiffness_low", "stiffness_low_N_m", "least", 1.0),
    Column("stiffness_high", "stiffness_high_N_m", "most", 1.0),
)
# Told of each push of an unseen subject.
_TOLD = [
    f.name
    for f in fields(TaskScore)
    if f.name not in ("force_end", "peak_drift")
]


def table_1(evaluation: Evaluation) -> list[dict]:
    """Rows of Table 1: who, seed, numbers by column; the paper's last."""
    rows = [
        {
            "controller": controller.name,
            "seed": controller.seed if controller.policy else "",
            **cells_of(COLUMNS, score),
            "at_upper_bound": int(score.at_upper),
            "violates": int(score.violates),
        }
        for controller, _, score in evaluation.nominal
    ]
    papers = ("pic", TABLE_1_PIC), ("rlpic", TABLE_1_RLPIC)
    return rows + [
        {"controller": f"{name}, the paper", **cells_of(COLUMNS, stated)}
        for name, stated in papers
    ]


def summarize(evaluation: Evaluation) -> list[dict]:
    """One row for each controller on the unseen subjects.

    `median` and `violating` have 95 % intervals over subjects; `*_seeds` are
    means over seeds with Student's interval.
    """
    pic = evaluation.collect("pic", "y_rms")[0]
    rows = []
    for name in evaluation.unseen:
        error, force, over, total = (
            evaluation.collect(name, field)
            for field in ("y_rms", "peak_force", "violates", "total")
        )
        medians = np.median(1e3 * error, axis=1)
        rows.append(
            {
                "controller": name,
                "seeds": len(error),
                "median": median_interval(1e3 * error),
                "median_seeds": student_interval(medians),
                "violating": share_interval(over),
                "violations_seeds": student_interval(over.sum(axis=1)),
                "largest_force": student_interval(force.max(axis=1)),
                "better_than_pic": float(np.mean(error < pic)),
                "total": student_interval(total.mean(axis=1)),
            }
        )
    return rows


def pushes(evaluation: Evaluation) -> list[dict]:
    """Every push of an unseen subject, SI units, with the subject's factors."""
    rows = []
    for name, seeds in evaluation.unseen.items():
        for seed, row in enumerate(seeds):
            pairs = zip(row, evaluation.subjects, strict=True)
            for i, (score, subject) in enumerate(pairs):
                who = {"controller": name, "seed": seed, "subject": i}
                told = {field: getattr(score, field) for field in _TOLD}
                rows.append({**who, **told, **subject.describe()})
    return rows


def constants(evaluation: Evaluation) -> list[dict]:
    """What each constant stiffness does, on the nominal and unseen subjects."""
    search, own = evaluation.search, evaluation.nominal_search
    rows = []
    for i, (stiffness, scores) in enumerate(evaluation.sweep.items()):
        alone = evaluation.nominal_sweep[stiffness]
        error = np.array([s.y_rms for s in scores])
        over = np.array([s.violates for s in scores])
        rows.append(
            {
                "stiffness_N_m": stiffness,
                "nominal_return": own.totals[i],
                "nominal_y_rmse_mm": 1e3 * alone.y_rms,
                "nominal_violates": int(alone.violates),
                "searched_return": search.totals[i],
                "median": median_interval(1e3 * error),
                "violating": share_interval(over),
            }
        )
    return rows


def WriteTables(folder: Path, evaluation: Evaluation) -> None:
    """Writes table_1.csv, unseen.csv, pushes.csv and constants.csv.

    Args:
        folder: It exists.
    """
    for name, rows in (
        ("table_1", table_1),
        ("unseen", summarize),
        ("pushes", pushes),
        ("constants", constants),
    ):
        WriteText(folder / f"{name}.csv", format_csv(rows(evaluation)))
