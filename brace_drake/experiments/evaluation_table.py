"""An evaluation as CSV: the paper's Table 1, a summary, every push."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from brace_drake.core.output import WriteText
from brace_drake.experiments.compare import (
    TABLE_1_PIC,
    TABLE_1_RLPIC,
    PaperTable,
)
from brace_drake.experiments.evaluate import Evaluation
from brace_drake.experiments.scores import (
    FIELDS,
    Score,
    Spread,
    median_over,
    over_seeds,
    share_of,
)
from brace_drake.experiments.table_columns import (
    PEAK_FORCE,
    STIFFNESS,
    TABLE_1,
    Column,
)

MORE = (
    Column("start_rate", "start_rate_error_mm_s", "start of y', mm/s", 1e3),
    PEAK_FORCE,
    STIFFNESS,
    Column("stiffness_low", "stiffness_low_N_m", "least", 1.0),
    Column("stiffness_high", "stiffness_high_N_m", "most", 1.0),
)


def table_1(evaluation: Evaluation) -> list[dict]:
    """Rows of Table 1: who, seed, numbers by column; the paper's last."""
    rows = []
    for contestant, score in zip(
        evaluation.contestants, evaluation.nominal_scores, strict=True
    ):
        row = {
            "controller": contestant.name,
            "seed": contestant.seed if contestant.policy else "",
        }
        for c in (*TABLE_1, *MORE):
            row[c.name] = c.factor * getattr(score, c.measure)
        row["at_upper_bound"] = int(score.at_upper)
        row["violates"] = int(score.violates)
        rows.append(row)
    for name, paper in (
        ("pic, the paper", TABLE_1_PIC),
        ("rlpic, the paper", TABLE_1_RLPIC),
    ):
        rows.append({"controller": name, **_paper_row(paper)})
    return rows


def _paper_row(paper: PaperTable) -> dict:
    return {c.name: c.factor * getattr(paper, c.measure) for c in TABLE_1}


def nominal_of(evaluation: Evaluation, name: str) -> list[Score]:
    """Scores of a contestant's seeds on the nominal subject."""
    pairs = zip(evaluation.contestants, evaluation.nominal_scores, strict=True)
    return [score for contestant, score in pairs if contestant.name == name]


def summarize(evaluation: Evaluation) -> list[dict]:
    """One row for each contestant on the unseen subjects.

    `median` and `violating` have 95 % intervals over subjects; `*_seeds` are
    means over seeds with Student's interval.
    """
    pic = evaluation.collect("pic", "y_rms")[0]
    rows = []
    for name in evaluation.unseen:
        error = evaluation.collect(name, "y_rms")
        over = evaluation.collect(name, "violates").astype(bool)
        rows.append(
            {
                "controller": name,
                "seeds": len(error),
                "median": median_over(1e3 * error),
                "median_seeds": over_seeds(np.median(1e3 * error, axis=1)),
                "violating": share_of(over),
                "violations_seeds": over_seeds(over.sum(axis=1)),
                "largest_force": over_seeds(
                    evaluation.collect(name, "peak_force").max(axis=1)
                ),
                "better_than_pic": float(np.mean(error < pic)),
                "total": over_seeds(
                    evaluation.collect(name, "total").mean(axis=1)
                ),
            }
        )
    return rows


def format_rows(rows: list[dict]) -> str:
    """Rows as CSV; an interval takes three columns."""
    flat = [_flatten(row) for row in rows]
    columns = list(dict.fromkeys(k for row in flat for k in row))
    memory = io.StringIO()
    writer = csv.DictWriter(memory, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(flat)
    return memory.getvalue()


def _flatten(row: dict) -> dict:
    flat = {}
    for key, value in row.items():
        if isinstance(value, Spread):
            flat[key] = _number(value.value)
            flat[f"{key}_lower95"] = _number(value.lower)
            flat[f"{key}_upper95"] = _number(value.upper)
        else:
            flat[key] = _number(value)
    return flat


def _number(value):
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.6g}"
    return value


def pushes(evaluation: Evaluation) -> list[dict]:
    """Every push of an unseen subject, SI units, with the subject's factors."""
    rows = []
    for name, seeds in evaluation.unseen.items():
        for seed, row in enumerate(seeds):
            for i, (score, subject) in enumerate(
                zip(row, evaluation.subjects, strict=True)
            ):
                values = {f: getattr(score, f) for f in FIELDS}
                values |= {
                    k: int(v) for k, v in values.items() if isinstance(v, bool)
                }
                rows.append(
                    {
                        "controller": name,
                        "seed": seed,
                        "subject": i,
                        **values,
                        **subject.describe(),
                    }
                )
    return rows


def WriteTables(folder: Path, evaluation: Evaluation) -> None:
    """Writes table_1.csv, unseen.csv, pushes.csv and constants.csv.

    Args:
        folder: It exists.
    """
    WriteText(folder / "table_1.csv", format_rows(table_1(evaluation)))
    WriteText(folder / "unseen.csv", format_rows(summarize(evaluation)))
    WriteText(folder / "pushes.csv", format_rows(pushes(evaluation)))
    WriteText(folder / "constants.csv", format_rows(constants(evaluation)))


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
                "median": median_over(1e3 * error),
                "violating": share_of(over),
            }
        )
    return rows
