"""Outcomes side by side, as CSV and Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from brace_drake.output import WriteText
from brace_drake.transfer.payoff import Outcome

# Measure, column, title, factor from SI.
_COLUMNS = (
    ("y_rms", "y_rmse_mm", "y, mm", 1e3),
    ("vy_rms", "vy_rmse_mm_s", "y', mm/s", 1e3),
    ("across_rms", "across_rmse_mm", "x and z, mm", 1e3),
    ("peak_force", "peak_force_N", "peak F_y, N", 1.0),
    ("over_force", "time_above_limit_percent", "above F_max, %", 100.0),
    ("stiffness", "stiffness_N_m", "K, N/m", 1.0),
)


def format_csv(outcomes: Sequence[Outcome]) -> str:
    """A row for each machine and controller."""
    names = [column for _, column, _, _ in _COLUMNS]
    lines = [",".join(["machine", "controller", *names])]
    for o in outcomes:
        cells = [f"{f * getattr(o, name):.6g}" for name, _, _, f in _COLUMNS]
        lines.append(",".join([o.cause, o.controller, *cells]))
    return "\n".join(lines) + "\n"


def format_markdown(outcomes: Sequence[Outcome]) -> str:
    """The table, and a sentence for each machine."""
    titles = [title for _, _, title, _ in _COLUMNS]
    lines = [
        "# Does closing the gap pay?",
        "",
        "Pushes of the machine that recorded the campaign, by PIC with the data"
        " sheet's stiffness and by policies trained on two twins of it.",
        "",
        "| machine | controller | " + " | ".join(titles) + " |",
        "|---|---|" + "---:|" * len(titles),
    ]
    for o in outcomes:
        cells = [f"{f * getattr(o, name):.4g}" for name, _, _, f in _COLUMNS]
        lines.append(f"| {o.cause} | {o.controller} | {' | '.join(cells)} |")
    return "\n".join([*lines, "", *conclude(outcomes)]) + "\n"


def conclude(outcomes: Sequence[Outcome]) -> list[str]:
    """For each machine, by how much the repaired twin's policy is better."""
    lines = []
    for cause in dict.fromkeys(o.cause for o in outcomes):
        of = {o.controller: o for o in outcomes if o.cause == cause}
        if not {"nominal", "repaired"} <= set(of):
            continue
        before, after = of["nominal"], of["repaired"]
        gain = 100.0 * (1.0 - after.y_rms / before.y_rms)
        word = "less" if gain >= 0.0 else "more"
        lines.append(
            f"- {cause}: the policy of the repaired twin has {abs(gain):.1f} %"
            f" {word} error along y than that of the nominal one"
            f" ({1e3 * after.y_rms:.4f} and {1e3 * before.y_rms:.4f} mm), and"
            f" is above F_max for {100 * after.over_force:.1f} % of the time"
            f" (nominal: {100 * before.over_force:.1f} %)."
        )
    return lines


def WritePayoff(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Writes payoff.csv and payoff.md into a folder that exists."""
    WriteText(folder / "payoff.csv", format_csv(outcomes))
    WriteText(folder / "payoff.md", format_markdown(outcomes))
