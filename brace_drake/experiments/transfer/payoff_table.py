"""Outcomes side by side, as CSV and Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from brace_drake.core.output import WriteText
from brace_drake.experiments.scores import Spread, over_seeds
from brace_drake.experiments.table_columns import (
    PEAK_FORCE,
    STIFFNESS,
    TABLE_1,
    Column,
)
from brace_drake.experiments.transfer.payoff import Outcome

_COLUMNS = (
    *TABLE_1[:2],
    Column("across_rms", "across_rmse_mm", "x and z, mm", 1e3),
    PEAK_FORCE,
    Column("over_force", "time_above_limit_percent", "above F_max, %", 100.0),
    STIFFNESS,
)


def spreads_of(outcomes: Sequence[Outcome]) -> dict[tuple[str, str], dict]:
    """Means over pushes with Student's 95 % interval.

    By machine and controller, then by column; in the column's unit.
    """
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for o in outcomes:
        groups.setdefault((o.cause, o.controller), []).append(o)
    return {
        key: {
            c.name: over_seeds(
                [c.factor * getattr(o, c.measure) for o in group]
            )
            for c in _COLUMNS
        }
        for key, group in groups.items()
    }


def format_csv(outcomes: Sequence[Outcome]) -> str:
    """A row for each machine and controller; a measure takes three columns."""
    names = [
        f"{column.name}{part}"
        for column in _COLUMNS
        for part in ("", "_lower95", "_upper95")
    ]
    lines = [",".join(["machine", "controller", *names])]
    for key, row in spreads_of(outcomes).items():
        cells = [
            "" if math.isnan(value) else f"{value:.6g}"
            for spread in row.values()
            for value in (spread.value, spread.lower, spread.upper)
        ]
        lines.append(",".join([*key, *cells]))
    return "\n".join(lines) + "\n"


def format_markdown(outcomes: Sequence[Outcome]) -> str:
    """The table, and a sentence for each machine."""
    titles = [column.title for column in _COLUMNS]
    lines = [
        "# Does closing the gap pay?",
        "",
        "Pushes of the machine that recorded the campaign, by PIC with the data"
        " sheet's stiffness and by policies trained on two twins of it. Means"
        " over pushes with 95 % intervals. These are of the machine's noise"
        " alone: each twin has one training, and what another seed of it would"
        " change is not in them.",
        "",
        "| machine | controller | " + " | ".join(titles) + " |",
        "|---|---|" + "---:|" * len(titles),
    ]
    for key, row in spreads_of(outcomes).items():
        cells = [_cell(spread) for spread in row.values()]
        lines.append(f"| {' | '.join([*key, *cells])} |")
    return "\n".join([*lines, "", *conclude(outcomes)]) + "\n"


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
                o.push: o
                for o in outcomes
                if (o.cause, o.controller) == (cause, who)
            }
            for who in ("nominal", "repaired")
        )
        if not before or set(before) != set(after):
            continue
        lines.append(f"- {cause}: {_compare(before, after)}")
    return lines


def _compare(before: dict[int, Outcome], after: dict[int, Outcome]) -> str:
    def mean(of, name):
        return float(np.mean([getattr(o, name) for o in of.values()]))

    old, new = mean(before, "y_rms"), mean(after, "y_rms")
    less = over_seeds(
        [100.0 * (before[i].y_rms - after[i].y_rms) / old for i in before]
    )
    numbers = (
        f"({1e3 * new:.4f} and {1e3 * old:.4f} mm), and is above F_max for"
        f" {100 * mean(after, 'over_force'):.1f} % of the time"
        f" (nominal: {100 * mean(before, 'over_force'):.1f} %)."
    )
    word = "less" if less.value >= 0.0 else "more"
    text = (
        f"the policy of the repaired twin has {abs(less.value):.1f} % {word}"
        f" error along y than that of the nominal one {numbers}"
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


def WritePayoff(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Writes payoff.csv and payoff.md into a folder that exists."""
    WriteText(folder / "payoff.csv", format_csv(outcomes))
    WriteText(folder / "payoff.md", format_markdown(outcomes))
