"""A diagnosis on one page, for a file or a print."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap

from brace_drake.core.output import MakeFolder, WriteBytes
from brace_drake.report.canvas import FLOOR, MEASURED, figure_style, plain
from brace_drake.report.certain import BADGES, describe_certain, kind_of
from brace_drake.report.export.figures import figure_bytes
from brace_drake.report.figures.traces import (
    COLORS,
    NAMES,
    draw_residual,
    draw_values,
)
from brace_drake.report.origin import view_origin
from brace_drake.report.traces import RunTrace, most_telling
from brace_drake.report.words import (
    percent,
    percent_interval,
    times,
)

FILE = "report.pdf"
# A4 and its margins, inches.
_PAGE, _LEFT, _TOP = (8.27, 11.69), 0.7, 0.6
_WIDTH = _PAGE[0] - 2.0 * _LEFT
# Characters per em, of the widest font and of its bold form.
_PER_EM, _PER_BOLD_EM = 1.75, 1.5
_LEADING = 1.35
_SOFT = "#5a6673"
# Characters of a fact of the provenance.
_MOST = 100


def WritePdf(
    diagnosis: dict, traces: Sequence[RunTrace], folder: Path
) -> list[Path]:
    """Writes the verdict, its numbers and the run that shows it as one page.

    Args:
        diagnosis: Content of diagnosis.json.
        traces: As for the report.
        folder: Of the results.

    Returns:
        The file.

    Raises:
        OutputError: The place cannot be written.
    """
    MakeFolder(folder)
    with figure_style():
        content = figure_bytes(_draw_page(diagnosis, traces), "pdf")
    WriteBytes(folder / FILE, content)
    return [folder / FILE]


class _Page:
    """A figure that is filled from its top."""

    def __init__(self):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.figure = Figure(figsize=_PAGE)
        FigureCanvasAgg(self.figure)
        self.y = _PAGE[1] - _TOP

    def say(self, text: str, size: float, gap: float = 0.0, **look) -> None:
        """Lines of text, `gap` inches below what stands there."""
        self.y -= gap
        is_bold = look.get("fontweight") == "bold"
        width = 72.0 * _WIDTH / size * (_PER_BOLD_EM if is_bold else _PER_EM)
        for line in wrap(text, int(width)) or [""]:
            self.y -= size * _LEADING / 72.0
            self.figure.text(
                _LEFT / _PAGE[0],
                self.y / _PAGE[1],
                plain(line),
                fontsize=size,
                **look,
            )

    def panel(self, height: float, above: float):
        """Axes of the full width, with room for a title above."""
        self.y -= above + height
        left, width = (_LEFT + 0.15) / _PAGE[0], (_WIDTH - 0.15) / _PAGE[0]
        return self.figure.add_axes(
            (left, self.y / _PAGE[1], width, height / _PAGE[1])
        )


def _draw_page(diagnosis: dict, traces: Sequence[RunTrace]):
    page, verdict = _Page(), diagnosis["verdict"]
    certain = describe_certain(diagnosis)
    head = f"Diagnosis of {diagnosis['campaign']}, {diagnosis['device']}"
    page.say(head, 9, color=_SOFT)
    page.say(BADGES[kind_of(verdict)], 10, 0.08, fontweight="bold")
    page.say(verdict["sentence"], 13, 0.03, fontweight="bold")
    page.say(_certainty(diagnosis), 9.5, 0.1)
    for text in (certain["rest"], certain["validation"]):
        if text and text not in verdict["sentence"]:
            page.say(text, 9.5, 0.04)
    for row in verdict["recording"]:
        page.say(f"Remedy: {row['remedy']}.", 9.5, 0.04)
    _draw_gap(page, traces)
    for row in certain["supported"]:
        page.say(_effect_text(row), 9, 0.06)
    for row in certain["law"]:
        text = f"Law of what is left: {row['text']}; {row['formula']} with"
        page.say(f"{text} {row['numbers']} (95 %).", 9, 0.06)
    _say_origin(page, diagnosis)
    return page.figure


def _certainty(diagnosis: dict) -> str:
    verdict, shrink = diagnosis["verdict"], diagnosis["shrink"] or {}
    sure = percent(verdict["probability"])
    text = f"Probability that the verdict is right: {sure}."
    if shrink.get("closed") is not None and verdict["effects"]:
        ends = shrink["closed_interval"] or (None, None)
        share, interval = percent_interval(shrink["closed"], *ends)
        text += f" Gap closed on the validation runs: {share}"
        text += f" (95 % interval {interval})" if interval else ""
        text += f", from {times(shrink['before'])} to {times(shrink['after'])}"
        text += " times the noise floor."
    return text


def _effect_text(row: dict) -> str:
    numbers = "; ".join(
        f"{p['name']} {p['value']} {p['unit']} ({p['interval']})".strip()
        for p in row["parameters"]
    )
    text = f"{row['title']}: probability {percent(row['probability'])}"
    return f"{text}; {numbers} (95 % intervals)." if numbers else f"{text}."


def _draw_gap(page: _Page, traces: Sequence[RunTrace]) -> None:
    """The run and channel that show the gap best."""
    from matplotlib.lines import Line2D

    found = most_telling(traces)
    if found is None:
        return
    trace, c = traces[found[0]], found[1]
    text = f"Run {trace.name} ({trace.split}), which shows the gap best"
    page.say(text, 10, 0.14, fontweight="bold")
    handles = [Line2D([], [], color="#b3bcc6", lw=3.6, label="measured")]
    handles += [
        Line2D([], [], color=COLORS[kind], lw=1.8, label=NAMES[kind])
        for kind, _ in trace.twins()
    ]
    values = page.panel(1.9, 0.42)
    draw_values(values, trace, c)
    values.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.1),
        ncols=4,
        borderaxespad=0.0,
    )
    residual = page.panel(1.3, 0.42)
    draw_residual(residual, trace, c)
    for axes in (values, residual):
        axes.set_xlim(trace.time_s[0], trace.time_s[-1])
    residual.set_xlabel("time, s")
    page.say("Grey band: ±2 times the noise floor.", 8, 0.4, color=_SOFT)


def _say_origin(page: _Page, diagnosis: dict) -> None:
    """From what the page was made, and by what."""
    page.say("Provenance", 10, 0.14, fontweight="bold", color=MEASURED)
    splits = [row["split"] for row in diagnosis["runs"]]
    counts = [f"{splits.count(s)} {s}" for s in ("fit", "validation")]
    page.say(f"runs: {' and '.join(counts)}", 8)
    for name, text in view_origin(diagnosis)["facts"]:
        page.say(f"{name}: {_shorten(text)}", 8)
    versions = diagnosis["provenance"]["versions"].items()
    page.say("versions: " + ", ".join(f"{k} {v}" for k, v in versions), 8)
    page.say(
        "Research software. Not a medical device: nothing here may guide a"
        " treatment.",
        8,
        0.08,
        color=FLOOR,
    )


def _shorten(text: str) -> str:
    """A long command or hash, cut so that it fits on one line."""
    return text if len(text) <= _MOST else f"{text[: _MOST - 1]}…"
