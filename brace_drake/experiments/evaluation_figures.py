"""Figures 8 to 13 of the paper, and the unseen subjects, as PNG."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brace_drake.core.output import WriteBytes
from brace_drake.experiments.evaluate import Evaluation
from brace_drake.experiments.rollouts import TaskScore
from brace_drake.experiments.tables import to_png
from brace_drake.report.canvas import (
    FLOOR,
    WIDTH,
    figure_style,
    make_figure,
    plain,
)

_COLOURS = {
    "pic": "#d55e00",
    "npic": "#cc79a7",
    "mraic": "#e69f00",
    "vpic": "#009e73",
    "constant": "#6b7785",
}
_POLICIES = ("#0072b2", "#56b4e9", "#8a4b82", "#332288")
_DESIRED = "#1f2933"


def colour_of(evaluation: Evaluation, name: str) -> str:
    """The colour of a controller in all figures."""
    if name in _COLOURS:
        return _COLOURS[name]
    at = evaluation.policy_names.index(name)
    return _POLICIES[at % len(_POLICIES)]


def draw_paper_figures(evaluation: Evaluation) -> dict[str, bytes]:
    """Figures 8 to 13 by name, of PIC, the tuned constant and the policies."""
    i = evaluation.benchmark.pushed
    x, z = 6 * (i // 6), 6 * (i // 6) + 2
    return {
        f"figure_{8 + k}": _draw_panel(evaluation, *panel)
        for k, panel in enumerate(
            (
                ("position along y, mm", "position", "desired", i, 1e3),
                ("velocity along y, mm/s", "rate", "desired_rate", i, 1e3),
                ("position along x, mm", "position", "desired", x, 1e3),
                ("position along z, mm", "position", "desired", z, 1e3),
                ("force of the torso along y, N", "force", None, i, 1.0),
                ("desired stiffness along y, N/m", "stiffness", None, i, 1.0),
            )
        )
    }


def _draw_panel(
    evaluation: Evaluation,
    title: str,
    field: str,
    wanted: str | None,
    j: int,
    factor: float,
) -> bytes:
    """Draws a signal's coordinate j over time, and what is desired of it."""
    with figure_style():
        figure = make_figure(WIDTH / 2, 2.7)
        axes = figure.subplots()
        seen: set[str] = set()
        for controller, rollout, _ in evaluation.nominal:
            name = controller.name
            if name in ("npic", "mraic", "vpic"):
                continue
            values = (
                rollout.stiffness[:, 0]
                if field == "stiffness"
                else factor * getattr(rollout.signals, field)[:, j]
            )
            axes.plot(
                rollout.time,
                values,
                color=colour_of(evaluation, name),
                lw=1.1,
                ls="--" if name == "constant" else "-",
                label=None if name in seen else plain(name),
            )
            seen.add(name)
        if wanted is not None:
            first = evaluation.nominal[0].rollout
            values = factor * getattr(first.signals, wanted)[:, j]
            axes.plot(first.time, values, ":", color=_DESIRED, label="desired")
        else:
            _add_bounds(evaluation, axes, field)
        axes.set_title(title)
        axes.set_xlabel("time, s")
        axes.grid(True)
        axes.legend(fontsize=7.5)
        return to_png(figure)


def _add_bounds(evaluation: Evaluation, axes, field: str) -> None:
    benchmark = evaluation.benchmark
    if field == "force":
        limit = benchmark.force_limit
        axes.axhline(limit, color=FLOOR, ls=":", label="$F_{max}$")
        return
    for bound in (benchmark.law.lower, benchmark.law.upper):
        axes.axhline(bound, color=FLOOR, ls=":", lw=0.8)
    axes.set_yscale("log")


def draw_unseen(evaluation: Evaluation) -> bytes:
    """Error and force of every push, and what constants trade, as PNG."""
    names = list(evaluation.unseen)
    with figure_style():
        figure = make_figure(WIDTH, 3.9)
        error, force, trade = figure.subplots(
            1, 3, width_ratios=[1.1, 1.0, 1.3]
        )
        at = np.arange(len(names))[::-1]
        for place, name in zip(at, names, strict=True):
            colour = colour_of(evaluation, name)
            for axes, field, factor in (
                (error, "y_rms", 1e3),
                (force, "peak_force", 1.0),
            ):
                values = factor * evaluation.collect(name, field).ravel()
                values = values[np.isfinite(values)]
                if not len(values):
                    continue  # All of its pushes have failed.
                spots = place + np.linspace(-0.3, 0.3, len(values))
                axes.plot(values, spots, ".", color=colour, ms=2.5, alpha=0.6)
                middle = np.median(values)
                axes.plot([middle] * 2, [place - 0.4, place + 0.4], color="k")
        _use_logarithm(error)
        error.set_yticks(at, [plain(n) for n in names])
        force.set_yticks(at, [""] * len(names))
        force.axvline(evaluation.benchmark.force_limit, color=FLOOR, ls=":")
        error.set_title("RMSE of y, mm")
        force.set_title("peak force along y, N")
        _draw_trade(evaluation, trade)
        for axes in (error, force, trade):
            axes.grid(True)
        return to_png(figure)


def _use_logarithm(axes) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, at: f"{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _draw_trade(evaluation: Evaluation, axes) -> None:
    """Pushes above F_max over the median error: constants and controllers."""
    sweep = {K: _trade_of(row) for K, row in evaluation.sweep.items()}
    sweep = {K: point for K, point in sweep.items() if np.isfinite(point[0])}
    if sweep:
        points = np.transpose([*sweep.values()])
        axes.plot(*points, "-", color=FLOOR, lw=1.0, marker=".")
    for K, point in sweep.items():
        axes.annotate(f"{K:.0f}", point, fontsize=6.5, color=FLOOR)
    for name, rows in evaluation.unseen.items():
        colour = colour_of(evaluation, name)
        for seed, row in enumerate(rows):
            point = _trade_of(row)
            label = None if seed else plain(name)
            axes.plot(*point, "o", color=colour, ms=5, label=label)
    _use_logarithm(axes)
    axes.set_xlabel("median RMSE of y, mm; line: constants, N/m")
    axes.set_title("pushes beyond a limit, %")
    axes.legend(fontsize=7)


def _trade_of(row: list[TaskScore]) -> tuple[float, float]:
    errors, over = [s.y_rms for s in row], [s.violates for s in row]
    return 1e3 * float(np.median(errors)), 100.0 * float(np.mean(over))


def WriteFigures(folder: Path, evaluation: Evaluation) -> dict[str, bytes]:
    """Writes figure_8.png to figure_13.png and unseen.png; returns them."""
    drawn = draw_paper_figures(evaluation)
    drawn["unseen"] = draw_unseen(evaluation)
    for name, data in drawn.items():
        WriteBytes(folder / f"{name}.png", data)
    return drawn
