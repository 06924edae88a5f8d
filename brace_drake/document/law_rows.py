"""The law of what is left, as rows of a document and in words."""

from __future__ import annotations

import itertools

import numpy as np

from brace_drake.discrepancy import FoundLaw
from brace_drake.effects.unknown import describe_term, is_term


def law_row(law: FoundLaw | None) -> dict | None:
    """Terms with their parameters, and what the law closes; None without.

    `closed` is the share of the gap on validation runs that the twin with all
    that is named and the law takes away.
    """
    if law is None:
        return None
    errors = iter(law.estimates.parameters[law.estimates.num_subject :])
    terms = []
    for effect, values in law.fit.uses:
        moved = effect.is_continuous
        own = itertools.islice(errors, int(moved.sum()))
        known = np.full(len(values), np.nan)
        known[: len(moved)][moved] = [
            np.nan if e.standard_error is None else e.standard_error
            for e in own
        ]
        # What runs have of their own stands in the table as well.
        runs = len(effect.run_parameters) * law.fit.num_runs
        next(itertools.islice(errors, runs, runs), None)
        if is_term(effect):
            terms.append(describe_term(effect, values, known))
    shrinkage = law.shrinkage or {}
    return {
        "text": "; and ".join(term["text"] for term in terms),
        "terms": terms,
        "closed": shrinkage.get("closed"),
        "closed_interval": shrinkage.get("closed_interval"),
    }


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
