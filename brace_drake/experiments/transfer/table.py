"""Outcomes side by side, as CSV and Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from brace_drake.core.output import WriteText
from brace_drake.experiments.tables import (
    PEAK_FORCE,
    STIFFNESS,
    TABLE_1,
    Column,
    Spread,
    cells_of,
    format_csv,
    format_table,
    student_interval,
)
from brace_drake.experiments.transfer.experiment import Outcome

_ACROSS = Column("across_rms", "across_rmse_mm", "x and z, mm", 1e3)
_OVER = Column(
    "over_force", "time_above_limit_percent", "above F_max, %", 100.0
)
_COLUMNS = (*TABLE_1[:2], _ACROSS, PEAK_FORCE, _OVER, STIFFNESS)


def spreads_of(outcomes: Sequence[Outcome]) -> list[dict]:
    """Means over pushes with Student's 95 % interval, in the columns' units.

    A row for each machine and controller.
    """
    groups: dict[tuple[str, str], list[dict]] = {}
    for o in outcomes:
        cells = cells_of(_COLUMNS, o.score) | cells_of(_COLUMNS, o)
        groups.setdefault((o.cause, o.controller), []).append(cells)
    return [
        {
            "machine": cause,
            "controller": controller,
            **{
                c.name: student_interval([cells[c.name] for cells in group])
                for c in _COLUMNS
            },
        }
        for (cause, controller), group in groups.items()
    ]


def format_markdown(outcomes: Sequence[Outcome]) -> str:
    """The table, and a sentence for each machine."""
    titles = ["machine", "controller", *(c.title for c in _COLUMNS)]
    rows = [
        [_cell(v) if isinstance(v, Spread) else v for v in row.values()]
        for row in spreads_of(outcomes)
    ]
    lines = [
        "# Does closing the gap pay?",
        "",
        "Pushes of the machine that recorded the campaign, by PIC with the data"
        " sheet's stiffness and by policies trained on two twins of it. Means"
        " over pushes with 95 % intervals. These are of the machine's noise"
        " alone: each twin has one training, and what another seed of it would"
        " change is not in them.",
        "",
        format_table(titles, rows),
        "",
    ]
    return "\n".join([*lines, *conclude(outcomes)]) + "\n"


def conclude(outcomes: Sequence[Outcome]) -> list[str]:
    """For each machine, by how much the repaired twin's policy is better.

    Pushes of a number have the same chance under both, so that their
    difference is what is judged. Where its interval holds 0, or there is one
    push alone, the two are not separable.
    """
    lines = []
    for cause in dict.fromkeys(o.cause for o in outcomes):
        before, after = (
            {
                o.number: o
                for o in outcomes
                if (o.cause, o.controller) == (cause, who)
            }
            for who in ("nominal", "repaired")
        )
        if before and set(before) == set(after):
            pairs = [(before[i], after[i]) for i in before]
            lines.append(f"- {cause}: {_compare(pairs)}")
    return lines


def _compare(pairs: Sequence[tuple[Outcome, Outcome]]) -> str:
    errors = np.array([[o.score.y_rms for o in pair] for pair in pairs])
    old, new = errors.mean(axis=0)
    less = student_interval(100.0 * (errors[:, 0] - errors[:, 1]) / old)
    over = np.mean([[o.over_force for o in pair] for pair in pairs], axis=0)
    word = "less" if less.value >= 0.0 else "more"
    text = (
        f"the policy of the repaired twin has {abs(less.value):.1f} % {word}"
        f" error along y than that of the nominal one ({1e3 * new:.4f} and"
        f" {1e3 * old:.4f} mm), and is above F_max for {100 * over[1]:.1f} % of"
        f" the time (nominal: {100 * over[0]:.1f} %)."
    )
    if math.isnan(less.lower):
        return f"{text} One push has no interval: not separable."
    span = (
        f"95 % interval of what is less {less.lower:.1f} to {less.upper:.1f} %"
    )
    if less.lower <= 0.0 <= less.upper:
        return f"{text} Not separable: {span}."
    return f"{text} Separable: {span}."


def _cell(spread: Spread) -> str:
    if math.isnan(spread.lower):
        return f"{spread.value:.4g}"
    half = spread.upper - spread.value
    return f"{spread.value:.4g} +- {half:.2g}"


def WriteTransfer(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Writes payoff.csv and payoff.md into a folder that exists."""
    WriteText(folder / "payoff.csv", format_csv(spreads_of(outcomes)))
    WriteText(folder / "payoff.md", format_markdown(outcomes))
