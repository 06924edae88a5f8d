"""The verdict in words."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

from brace_drake.effects.card import Effect
from brace_drake.effects.registry import choice_words
from brace_drake.report.words import parameter_text


def verdict_sentence(
    name: str,
    effects: Sequence[Effect],
    gap: bool,
    closed: float | None,
    values: Sequence[dict],
) -> str:
    """One sentence that says what was found.

    Args:
        name: Of the campaign.
        effects: Cards of the verdict's effects.
        gap: Whether there is a gap.
        closed: Share of it that the effects close on validation runs.
        values: Rows of `effect_parameters`, one effect's after the other's.
    """
    if not gap:
        return (
            f"No gap: with the subject's parameters fitted, the twin"
            f" reproduces {name} down to its noise."
        )
    if not effects:
        return (
            f"There is a gap in {name}, and no effect in the library explains"
            " it."
        )
    left, causes = iter(values), []
    for effect in effects:
        size = 1 if effect.spread else len(effect.parameters)
        own = [_value_text(row) for row in islice(left, size)]
        causes.append(f"{effect.title} ({', '.join(own)})")
    text = f"The gap in {name} is explained by {' and '.join(causes)}"
    if closed is not None:
        them = "it" if len(causes) == 1 else "them"
        # More than all is noise.
        share = "100" if closed >= 1.0 else f"{100.0 * closed:.1f}"
        if 0.9995 < closed < 1.0:
            share = "more than 99.9"
        text += f"; adding {them} closes {share} % of the gap on the validation"
        text += " runs"
    return text + "."


def _value_text(row: dict) -> str:
    """A fitted parameter as a reader has it: clearance 2.033 mm."""
    name, unit, value = row["name"], row["unit"], row["value"]
    words = choice_words(name, value)
    if words is not None:
        return words
    if unit == "m":
        value, shown = 1e3 * value, "mm"
    else:
        shown = "" if unit == "1" else unit
    return f"{parameter_text(name, unit)} {value:.4g} {shown}".strip()
