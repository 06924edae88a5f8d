"""The paper's Table 1 beside the twin's, and Figures 8 to 13."""

from __future__ import annotations

from pathlib import Path

from brace_drake.core.output import WriteBytes, WriteText
from brace_drake.experiments.paper_torso.lean import FITTED, FittedLean
from brace_drake.experiments.paper_torso.pushes import ALONE, PaperPush
from brace_drake.experiments.paper_torso.reach import (
    frequencies_of,
    inertial_force_rms,
)
from brace_drake.experiments.tables import (
    PEAK_FORCE,
    STIFFNESS,
    TABLE_1,
    TABLE_1_PIC,
    TABLE_1_RLPIC,
    Column,
    cells_of,
    format_csv,
    format_table,
    to_png,
)
from brace_drake.report.canvas import WIDTH, figure_style, make_figure
from brace_drake.scenario.brace import BraceScenario

_COLUMNS = (
    *TABLE_1,
    PEAK_FORCE,
    STIFFNESS,
    Column("stiffness_low", "stiffness_low_N_m", "least K, N/m", 1.0),
    Column("stiffness_high", "stiffness_high_N_m", "most K, N/m", 1.0),
)
_START = Column(
    "start_velocity", "start_velocity_mm_s", "start of y', mm/s", 1e3
)
# Read off its Figure 9; the mean stiffness is of its Figure 13.
_PAPER = {
    "pic": (TABLE_1_PIC, {_START.name: -2.8, STIFFNESS.name: 6000.0}),
    "rlpic": (TABLE_1_RLPIC, {_START.name: -0.6, STIFFNESS.name: 49990.0}),
}
_COLOURS = {"pic": "#d55e00", "rlpic": "#0072b2", "constant": "#6b7785"}
_DESIRED = "#1f2933"
_WITHIN = 0.25
# Name, title, signal, what is desired of it, coordinate, factor.
_FIGURES = (
    ("figure_8", "position along y, mm", "position", "desired", 1, 1e3),
    ("figure_9", "velocity along y, mm/s", "rate", "desired_rate", 1, 1e3),
    ("figure_10", "position along x, mm", "position", "desired", 0, 1e3),
    ("figure_11", "position along z, mm", "position", "desired", 2, 1e3),
    ("figure_12", "force along y, N", "force", None, 1, 1.0),
    ("figure_13", "desired stiffness along y, N/m", "stiffness", None, 0, 1.0),
)


def table_rows(pushes: list[PaperPush]) -> list[dict]:
    """Rows of the table by column; the paper's first."""
    rows = [
        {
            "controller": name,
            "setting": "the paper",
            **cells_of(_COLUMNS, stated),
            **more,
        }
        for name, (stated, more) in _PAPER.items()
    ]
    return rows + [
        {
            "controller": push.controller,
            "setting": push.setting,
            **cells_of(_COLUMNS, push.score),
            **cells_of((_START,), push),
        }
        for push in pushes
    ]


def format_page(
    pushes: list[PaperPush],
    scenario: BraceScenario,
    fitted: FittedLean | None,
) -> str:
    """The table, the torso's numbers and what they reach, as Markdown."""
    columns = (*TABLE_1, _START, *_COLUMNS[len(TABLE_1) :])
    cells = [
        [
            row["controller"],
            row["setting"],
            *(f"{row[c.name]:.4g}" if c.name in row else "" for c in columns),
        ]
        for row in table_rows(pushes)
    ]
    titles = ["controller", "torso", *(c.title for c in columns)]
    lines = [
        "# The paper's Table 1 on a torso that leans on the pad",
        "",
        "Root mean square errors; the force is taken about its final value.",
        "",
        format_table(titles, cells),
        "",
        *(f"- {line}" for line in explain(pushes, scenario, fitted)),
    ]
    return "\n".join(lines) + "\n"


def explain(
    pushes: list[PaperPush],
    scenario: BraceScenario,
    fitted: FittedLean | None,
) -> list[str]:
    """What is met, and what would be needed for the rest, by the numbers."""
    found = {p.controller: p.score for p in _shown(pushes)}
    near = [
        c.title
        for c in TABLE_1
        if abs(_ratio(found["pic"], TABLE_1_PIC, c) - 1.0) <= _WITHIN
    ]
    lines = [_of_torso(scenario, fitted)]
    lines.append(
        f"PIC: {len(near)} of 5 entries are within {100 * _WITHIN:.0f} % of the"
        f" paper's: {'; '.join(near) or 'none'}."
    )
    for name in sorted(found.keys() - {"pic"}):
        below = [
            c.title
            for c in TABLE_1
            if _ratio(found[name], TABLE_1_RLPIC, c) <= 1.0
        ]
        lines.append(
            f"{name}, predicted: {len(below)} of 5 entries are at or below the"
            f" paper's RLPIC: {'; '.join(below) or 'none'}."
        )
    return lines + _limits(scenario)


def _shown(pushes: list[PaperPush]) -> list[PaperPush]:
    return [push for push in pushes if push.setting == ALONE]


def _of_torso(scenario: BraceScenario, fitted: FittedLean | None) -> str:
    lean, pad = scenario.torso.lean, scenario.contact.ring2
    load = abs(scenario.start.torso[1]) * pad.stiffness
    how = "as the scenario has it"
    if fitted is not None:
        end = "converged" if fitted.success else "did not converge"
        how = (
            f"fitted to {len(FITTED)} entries of the paper's PIC in"
            f" {fitted.evaluations} pushes; the solver {end}"
        )
    return (
        f"The torso leans with {lean[0]:.3f}, {lean[1]:.3f} and {lean[2]:.3f} N"
        f" along x, y and z; at the start the pad carries {load:.3f} N ({how})."
    )


def _limits(scenario: BraceScenario) -> list[str]:
    pad, mass = scenario.contact.ring2, scenario.torso.mass
    law = mass, pad.stiffness, pad.damping
    slow, fast = frequencies_of(TABLE_1_PIC, *law)
    learned, _ = frequencies_of(TABLE_1_RLPIC, *law)
    inertia = inertial_force_rms(mass, 0.01, 12.0)
    return [
        f"Velocity of the paper's PIC: {1e3 * TABLE_1_PIC.vy_rms:.3f} mm/s with"
        f" {TABLE_1_PIC.force_rms:.3f} N behind this pad and {mass:g} kg need a"
        f" motion slower than {slow:.2f} rad/s or faster than {fast:.0f} rad/s."
        f" Torso and pad swing at {(pad.stiffness / mass) ** 0.5:.1f} rad/s.",
        f"Velocity of its RLPIC: {1e3 * TABLE_1_RLPIC.vy_rms:.3f} mm/s with"
        f" {TABLE_1_RLPIC.force_rms:.4f} N need a motion slower than"
        f" {learned:.2f} rad/s.",
        f"Force of its RLPIC: {mass:g} kg that follow the cubic without any"
        f" error already need {inertia:.4f} N rms about the end;"
        f" {TABLE_1_RLPIC.force_rms:.4f} N are"
        f" {mass * TABLE_1_RLPIC.force_rms / inertia:.1f} kg.",
    ]


def _ratio(score, stated, column: Column) -> float:
    return getattr(score, column.measure) / getattr(stated, column.measure)


def draw_figures(pushes: list[PaperPush]) -> dict[str, bytes]:
    """Figures 8 to 13 by name, of stage 2 on the leaning torso, as PNG."""
    return {name: _draw(_shown(pushes), *rest) for name, *rest in _FIGURES}


def _draw(pushes, title, field, wanted, j, factor) -> bytes:
    with figure_style():
        figure = make_figure(WIDTH / 2, 2.7)
        axes = figure.subplots()
        for push in pushes:
            signals = push.rollout.signals
            values = (
                push.rollout.stiffness[:, j]
                if field == "stiffness"
                else factor * getattr(signals, field)[:, j]
            )
            axes.plot(
                push.rollout.time,
                values,
                color=_COLOURS[push.controller],
                ls="--" if push.controller == "constant" else "-",
                lw=1.1,
                label=push.controller,
            )
        if wanted is not None:
            values = factor * getattr(pushes[0].rollout.signals, wanted)[:, j]
            time = pushes[0].rollout.time
            axes.plot(time, values, ":", color=_DESIRED, label="desired")
        if field == "stiffness":
            axes.set_yscale("log")
        axes.set_title(title)
        axes.set_xlabel("time, s")
        axes.grid(True)
        axes.legend(fontsize=7.5)
        return to_png(figure)


def WritePaper(
    folder: Path,
    pushes: list[PaperPush],
    scenario: BraceScenario,
    fitted: FittedLean | None = None,
) -> None:
    """Writes table_1.csv, table_1.md and figure_8.png to figure_13.png."""
    WriteText(folder / "table_1.csv", format_csv(table_rows(pushes), digits=5))
    page = format_page(pushes, scenario, fitted)
    WriteText(folder / "table_1.md", page)
    for name, png in draw_figures(pushes).items():
        WriteBytes(folder / f"{name}.png", png)
