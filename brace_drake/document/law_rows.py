"""The law of what is left, as rows of a document and in words."""

from __future__ import annotations

import numpy as np

from brace_drake.discrepancy import FoundLaw
from brace_drake.document.rows import parameters_by_effect
from brace_drake.effects.unknown import describe_term, is_term


def law_row(law: FoundLaw | None) -> dict | None:
    """Terms with their parameters, and what the law closes; None without.

    `closed` is the share of the gap on validation runs that the twin with all
    that is named and the law takes away.
    """
    if law is None:
        return None
    rows = parameters_by_effect(law.fit, law.estimates)
    terms = [
        describe_term(effect, values, _errors(rows[effect.cause]))
        for effect, values in law.fit.uses
        if is_term(effect)
    ]
    shrinkage = law.shrinkage or {}
    return {
        "text": "; and ".join(term["text"] for term in terms),
        "terms": terms,
        "closed": shrinkage.get("closed"),
        "closed_interval": shrinkage.get("closed_interval"),
    }


def _errors(rows: list[dict]) -> np.ndarray:
    """Standard errors, NaN where they are not known."""
    known = [row["standard_error"] for row in rows]
    return np.array([np.nan if e is None else e for e in known])


def law_sentence(row: dict | None) -> str:
    """What is left in the words of its law; empty without one."""
    if row is None:
        return ""
    text = f" What is left acts like {row['text']}"
    usual = [t["usual"] for t in row["terms"] if t["usual"]]
    if usual:
        text += f" ({'; '.join(dict.fromkeys(usual))}?)"
    if row["closed"] is not None:
        share = 100.0 * max(0.0, row["closed"])
        text += f"; with it the twin closes {share:.1f} % of the gap on the"
        text += " validation runs"
    return f"{text}."
