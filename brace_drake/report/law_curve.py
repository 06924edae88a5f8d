"""The law of what is left over the variable that it depends on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.report.figures.law import draw_law


@dataclass(frozen=True)
class LawCurve:
    """One term of a law along the recorded motions.

    Attributes:
        text: The term in words.
        variable: What it is drawn over, in words with its unit.
        quantity: What it gives, in words with its unit.
        runs: Of each run its name, split, the variable (N,) and what the term
            gives (N,), along what was measured.
        found: What the recordings say without the law: the variable (M,), and
            mean, lower and upper end of the spread (M, 3) of the force that
            the twin lacks, ends NaN for a line; None where they do not say it
            directly.
        found_words: How that was obtained.
    """

    text: str
    variable: str
    quantity: str
    runs: tuple[tuple[str, str, np.ndarray, np.ndarray], ...]
    found: tuple[np.ndarray, np.ndarray] | None = None
    found_words: str = ""


def view_law(law: LawCurve) -> dict:
    """Figure and caption of one term."""
    caption = "Green: what the law gives along the recorded motions."
    if law.found is not None:
        caption += f" Dark or grey: {law.found_words}; not used by its fit."
    return {"text": law.text, "image": draw_law(law), "caption": caption}
