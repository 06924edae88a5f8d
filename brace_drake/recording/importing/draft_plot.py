"""A picture of a file's columns and what each was taken for."""

from __future__ import annotations

import io

import numpy as np

from brace_drake.recording.importing.draft import Draft

_ACROSS, _MOST_POINTS, _MOST_PANELS = 4, 2000, 60


def plot_draft(draft: Draft) -> bytes:
    """A panel for each column over the time, as PNG: accept or correct."""
    from matplotlib.figure import Figure

    guesses, table = draft.guesses, draft.table
    clock = next((g.column for g in guesses if g.channel == "time_s"), None)
    shown = [g for g in guesses if g.column != clock][:_MOST_PANELS]
    down = max(-(-len(shown) // _ACROSS), 1)
    figure = Figure(figsize=(4.0 * _ACROSS, 2.2 * down), layout="constrained")
    panels = figure.subplots(down, _ACROSS, squeeze=False).ravel()
    for panel in panels[len(shown) :]:
        panel.axis("off")
    for panel, guess in zip(panels, shown, strict=False):
        values = table[guess.column]
        step = max(len(values) // _MOST_POINTS, 1)
        time = table.get(clock or "", np.arange(0))
        if len(time) != len(values):
            time = np.arange(len(values))
        is_open = guess.channel is None
        panel.plot(time[::step], values[::step], lw=0.8, color=f"C{is_open:d}")
        panel.set_title(
            f"{guess.column[:40]!s}\n{guess.channel or 'not used'}",
            fontsize=9,
            parse_math=False,
        )
        panel.set_ylabel(guess.unit or "unit not stated", fontsize=8)
        panel.tick_params(labelsize=8)
    figure.supxlabel(clock or "sample", fontsize=9, parse_math=False)
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=100)
    return memory.getvalue()
