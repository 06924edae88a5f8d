"""Figures of a validation: displacement, network, forces."""

from __future__ import annotations

from pathlib import Path

from brace_drake.core.output import WriteBytes, WriteJson
from brace_drake.experiments.tables import to_png
from brace_drake.experiments.validate import (
    Regression,
    ReplayedRun,
    Validation,
)
from brace_drake.report.canvas import (
    AFTER,
    BEFORE,
    FLOOR,
    MEASURED,
    WIDTH,
    figure_style,
    make_figure,
    plain,
)

_STYLES = (
    ("measured", MEASURED, "measured"),
    ("before", BEFORE, "twin, network's k and c"),
    ("after", AFTER, "twin, fitted"),
)


def draw_replay(replayed: ReplayedRun) -> bytes:
    """The recorded reference replayed: ring and torso along y, as PNG."""
    with figure_style():
        figure = make_figure(WIDTH, 5.2)
        axes = figure.subplots(2, 2, sharex=True, height_ratios=[1.6, 1.0])
        time = replayed.time
        for column, body in enumerate(("ring", "torso")):
            top, bottom = axes[:, column]
            measured = 1e3 * getattr(replayed.measured, body)
            if body == "ring":
                desired = 1e3 * replayed.desired
                top.plot(time, desired, "--", color=FLOOR, label="desired")
            for name, colour, label in _STYLES:
                y = 1e3 * getattr(getattr(replayed, name), body)
                top.plot(time, y, color=colour, lw=1.0, label=label)
                if name != "measured":
                    bottom.plot(time, y - measured, color=colour, lw=0.8)
            top.set_title(f"{body} along y, mm")
            bottom.set_title("twin minus measured, mm")
            bottom.set_xlabel("time, s")
            top.legend()
        _grid(axes)
        figure.suptitle(plain(f"Replay of {replayed.run.file}"))
        return to_png(figure)


def draw_regression(regression: Regression, file: str) -> bytes:
    """Measured force, the network's, and the error between them, as PNG."""
    with figure_style():
        figure = make_figure(WIDTH, 4.4)
        top, bottom = figure.subplots(2, sharex=True, height_ratios=[1.8, 1.0])
        found, time = regression.estimate, regression.time
        top.plot(time, regression.force, color=MEASURED, label="measured")
        top.plot(
            time,
            regression.predicted,
            "--",
            color=BEFORE,
            label=f"network: k {found.stiffness:.0f} N/m,"
            f" c {found.damping:.0f} N s/m",
        )
        top.set_title("force on the torso along y, N")
        top.legend()
        error = regression.predicted - regression.force
        bottom.plot(time, error, color=BEFORE)
        bottom.set_title(
            f"network minus measured, N; RMSE {regression.rmse:.3f} N"
        )
        bottom.set_xlabel("time, s")
        _grid([top, bottom])
        figure.suptitle(plain(f"Regression on {file}"))
        return to_png(figure)


def draw_forces(validation: Validation) -> bytes:
    """Twin and measured force, before and after the fit, as PNG."""
    words = {"fit": "fit run", "validation": "held back from the fit"}
    shown = validation.runs.items()
    with figure_style():
        figure = make_figure(WIDTH, 5.2)
        axes = figure.subplots(
            2, len(shown), squeeze=False, sharex="col", height_ratios=[1.6, 1.0]
        )
        for column, (split, replayed) in enumerate(shown):
            top, bottom = axes[:, column]
            rmse = replayed.errors()
            for name, colour, label in _STYLES:
                force = getattr(replayed, name).force
                if name != "measured":
                    label += f", RMSE {rmse[f'force_rmse_N_{name}']:.3f} N"
                    error = force - replayed.measured.force
                    bottom.plot(replayed.time, error, color=colour, lw=0.7)
                top.plot(
                    replayed.time, force, color=colour, lw=1.0, label=label
                )
            title = f"{replayed.run.file}, {words[split]}: force along y, N"
            top.set_title(plain(title))
            bottom.set_title("twin minus measured, N")
            bottom.set_xlabel("time, s")
            top.legend()
        _grid(axes)
        return to_png(figure)


def WriteValidation(folder: Path, validation: Validation) -> dict:
    """Writes replay.png, regression.png, force.png and validation.json.

    Args:
        folder: It exists.
        validation: What is drawn.

    Returns:
        What validation.json has.
    """
    shown = validation.runs["fit"]
    for name, png in (
        ("replay", draw_replay(shown)),
        ("regression", draw_regression(validation.regression, shown.run.file)),
        ("force", draw_forces(validation)),
    ):
        WriteBytes(folder / f"{name}.png", png)
    document = validation.document()
    WriteJson(folder / "validation.json", document)
    return document


def _grid(axes) -> None:
    for panel in getattr(axes, "flat", axes):
        panel.grid(True)
