"""The comparison of controllers as CSV, Markdown and figure."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brace_drake.core.output import WriteBytes, WriteText
from brace_drake.experiments.compare import ControllerRun
from brace_drake.experiments.scores import DRIFT_LIMIT_M, FORCE_LIMIT_N
from brace_drake.experiments.tables import (
    PEAK_FORCE,
    TABLE_1,
    TABLE_1_PIC,
    Column,
    cells_of,
    format_csv,
    format_table,
    to_png,
)
from brace_drake.report.canvas import WIDTH, figure_style, make_figure

_SCORES = (
    *TABLE_1,
    PEAK_FORCE,
    Column("force_end", "final_force_N", "final F_y, N", 1.0),
    Column("peak_drift", "peak_drift_mm", "peak x, z, mm", 1e3),
)
_LEG = Column("peak_leg", "peak_leg_force_N", "peak leg, N", 1.0)
# Okabe and Ito's, told apart by any reader.
_COLOURS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00")


def _rows(runs: list[ControllerRun], with_paper: bool) -> list[dict]:
    """What each run is named and measured; of the paper, what it states."""
    rows = [
        {
            "controller": run.tag,
            "setting": run.setting,
            **cells_of(_SCORES, run.score),
            **cells_of((_LEG,), run),
            "within_limits": "yes" if run.score.within_limits else "no",
        }
        for run in runs
    ]
    if with_paper:
        stated = cells_of(_SCORES, TABLE_1_PIC)
        setting = "the paper's Table 1"
        rows.append({"controller": "pic", "setting": setting, **stated})
    return rows


def format_markdown(
    runs: list[ControllerRun], reasons: list[str], with_paper: bool
) -> str:
    """The table with what its columns mean, and the reasons below."""
    columns = (*_SCORES, _LEG)
    titles = [column.title for column in columns]
    cells = [
        [
            row["controller"],
            row["setting"],
            *(f"{row[c.name]:.4f}" if c.name in row else "" for c in columns),
            row.get("within_limits", ""),
        ]
        for row in _rows(runs, with_paper)
    ]
    lines = [
        "# Controllers on the same push",
        "",
        "Root mean square errors of position and velocity, and of the force"
        " about its final value, as the paper's Table 1 has it; then extremes."
        f" Limits: {FORCE_LIMIT_N:g} N on y, {1e3 * DRIFT_LIMIT_M:g} mm on x"
        " and z.",
        "",
        format_table(
            ["controller", "setting", *titles, "within limits"], cells
        ),
    ]
    if reasons:
        lines += ["", "## PIC beside the paper's Table 1", ""]
        lines += [f"- {reason}" for reason in reasons]
    return "\n".join(lines) + "\n"


def draw_comparison(runs: list[ControllerRun]) -> bytes:
    """Errors and forces over time, and the measures as bars, as PNG."""
    with figure_style():
        figure = make_figure(WIDTH, 5.6)
        axes = figure.subplot_mosaic(
            [["y", "y", "F", "F"], ["b0", "b1", "b2", "b3"]],
            height_ratios=[1.5, 1.0],
        )
        colours = [_COLOURS[i % len(_COLOURS)] for i in range(len(runs))]
        for colour, run in zip(colours, runs, strict=True):
            log, i = run.log, run.ring
            y = log.desired[:, 0, i, 1] - log.X[:, i, 1]
            axes["y"].plot(log.time, 1e3 * y, color=colour, label=run.tag)
            axes["F"].plot(log.time, log.force[:, i, 1], color=colour)
        axes["y"].set_title("y desired minus y, mm")
        axes["F"].set_title("force on the torso along y, N")
        for name in ("y", "F"):
            axes[name].set_xlabel("time, s")
            axes[name].grid(True)
        axes["y"].legend(ncols=3)
        _draw_bars(axes, runs, colours)
        return to_png(figure)


def _draw_bars(axes, runs: list[ControllerRun], colours) -> None:
    tags = [run.tag for run in runs]
    at = np.arange(len(runs))[::-1]
    for panel, j in enumerate((0, 1, 4, 5)):
        name, _, title, factor = _SCORES[j]
        values = [factor * getattr(r.score, name) for r in runs]
        bars = axes[f"b{panel}"]
        drawn = bars.barh(at, values, color=colours, height=0.7)
        bars.bar_label(drawn, fmt="%.3g", padding=2, fontsize=7.5)
        bars.set_yticks(at, tags if panel == 0 else [""] * len(tags))
        bars.set_title(title if j == 5 else f"RMSE {title}")
        bars.margins(x=0.25)
        bars.tick_params(left=False)


def WriteComparison(
    folder: Path,
    runs: list[ControllerRun],
    paper_runs: list[ControllerRun],
    reasons: list[str],
) -> None:
    """Writes comparison.csv, comparison.md and comparison.png.

    Args:
        folder: It exists.
        runs: Of the controllers, drawn and listed.
        paper_runs: Of the paper's scenarios, listed below; may be none.
        reasons: What `explain_table_1` says.
    """
    listed, with_paper = [*runs, *paper_runs], bool(paper_runs)
    table = format_csv(_rows(listed, with_paper), digits=5)
    WriteText(folder / "comparison.csv", table)
    text = format_markdown(listed, reasons, with_paper)
    WriteText(folder / "comparison.md", text)
    WriteBytes(folder / "comparison.png", draw_comparison(runs))
