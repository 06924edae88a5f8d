"""Scores answers against the truth of withheld cases."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import scipy

from brace_drake.withheld.faults import SEVERITIES
from brace_drake.withheld.judged import Judged
from brace_drake.withheld.plain_answers import read_plain
from brace_drake.withheld.schemas import ANSWER, SEALED, check_shape
from brace_drake.withheld.seals import (
    ANSWERS,
    ANSWERS_FORMAT,
    VAULT_FORMAT,
    SealError,
    check_commitment,
    check_seal,
    read_cases,
    read_seals,
)

SCORE_FORMAT = "brace-score/1"
# A gap closed by this share is repaired.
_REPAIRED = 0.8
_BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 1.0)
# A probability nearer to 0 or 1 than this is held to be no surer.
SUREST = 1e-3


def load_judged(folder: Path, vault: Path, answers: Path) -> list[Judged]:
    """Truth beside answers, once seals and commitment have been verified.

    Args:
        folder: Of the cases and their seals.
        vault: With their truth.
        answers: Folder of `answer_cases`, or one file of any method, which
            has committed to nothing (see `plain_answers`).

    Raises:
        SealError: Truth or answers are not those that were sealed.
        AnswerError: A file is missing or of another format.
    """
    seals = read_seals(folder)
    truths = read_cases(vault, VAULT_FORMAT)
    if answers.is_file():
        _, given = read_plain(answers)
    else:
        given = read_cases(answers / ANSWERS, ANSWERS_FORMAT)
        check_commitment(folder, answers)
    for other, what in ((truths, "vault"), (given, "answers")):
        if set(other) != set(seals):
            raise SealError(f"{what}: not the cases of {folder}")
    judged = []
    for name, sealed in seals.items():
        check_shape(f"{vault}: {name}", truths[name], SEALED)
        check_shape(f"{answers}: {name}", given[name], ANSWER)
        truth = truths[name]["truth"]
        check_seal(name, truth, truths[name]["salt"], sealed)
        answer = given[name]
        told = answer["verdict"], answer["closed"], answer.get("seconds")
        judged.append(Judged(name, truth, *told))
    return judged


def method_of(answers: Path) -> str:
    """Under which answers stand in a table.

    Raises:
        AnswerError: It is a file of another format.
    """
    return read_plain(answers)[0] if answers.is_file() else answers.name


def score(judged: list[Judged], least: float) -> dict:
    """All figures of merit.

    Args:
        judged: The cases.
        least: Floors above which a gap counts as detectable.
    """
    clear = [j for j in judged if j.kind == "single" and j.is_detectable(least)]
    wrong = [j for j in judged if j.kind != "none"]
    return {
        "format": SCORE_FORMAT,
        "cases": len(judged),
        "detectable_floors": least,
        "shares": shares(judged, least),
        "answers_per_case": _of(
            np.mean, [len(j.answers) for j in clear if j.answers]
        ),
        "gap_closed_median": _of(
            np.median,
            [j.closed for j in judged if j.right and j.closed is not None],
        ),
        "closed_median": _of(np.median, _told(wrong, "closed")),
        "seconds_median": _of(np.median, _told(judged, "seconds")),
        **probability_scores(judged),
        "confusion": confusion(judged),
        "each": [_row(j) for j in judged],
    }


def shares(judged: list[Judged], least: float) -> dict[str, dict]:
    """Shares of the cases of each kind, by name; see `share_of`."""

    def of(*kinds: str) -> list[Judged]:
        return [j for j in judged if j.kind in kinds]

    single, pair, outside = of("single"), of("pair"), of("outside")
    wrong = of("single", "pair", "outside")
    clear = [j for j in single if j.is_detectable(least)]
    found = {
        "answered right": [j.right for j in judged],
        "no answer": [j.verdict is None for j in judged],
        "false alarms": [j.given != "none" for j in of("none")],
        "singles: first answer": [j.right for j in single],
        "detectable singles: first answer": [j.right for j in clear],
        "detectable singles: coverage": [j.covered for j in clear],
        "pairs: both named": [j.right for j in pair],
        "pairs, each detectable: both named": [
            j.right for j in pair if j.is_each_detectable(least)
        ],
        "pairs: at least one named": [
            bool(j.named & set(j.truth["effects"])) for j in pair
        ],
        "effects: exactly those at fault": [
            j.right for j in single + pair if j.names_effects
        ],
        "no gap where there is none": [j.given == "none" for j in of("none")],
        "wrong names with p above 0.8": [
            j.errs_surely for j in judged if j.names_effects
        ],
        "gap closed by 80 % or more": [
            j.closed is not None and j.closed >= _REPAIRED for j in wrong
        ],
        "outside: recall": [j.right for j in outside if j.names_effects],
        "outside: precision": [j.right for j in judged if j.given == "outside"],
        "library effects called outside": [
            j.given == "outside" for j in single + pair
        ],
        "blocks: exactly those at fault": [j.blocks_right for j in wrong],
        "detectable gaps: blocks at fault": [
            j.accuses_rightly for j in wrong if j.is_detectable(least)
        ],
    }
    for severity in SEVERITIES:
        found[f"singles, {severity}: first answer"] = [
            j.right for j in single if j.severity == severity
        ]
    return {name: share_of(hits) for name, hits in found.items()}


def share_of(hits: Iterable[bool]) -> dict:
    """How many of how many, and Wilson's 95 % interval of their share."""
    hits = [bool(hit) for hit in hits]
    interval = [0.0, 1.0]
    if hits:
        test = scipy.stats.binomtest(sum(hits), len(hits))
        interval = [float(end) for end in test.proportion_ci(method="wilson")]
    return {
        "hits": sum(hits),
        "count": len(hits),
        "share": sum(hits) / len(hits) if hits else None,
        "interval": interval,
    }


def probability_scores(judged: list[Judged]) -> dict:
    """Log score and Brier score (less is better), and the reliability."""
    told = [j for j in judged if j.probability is not None]
    if not told:
        return {"log_score": None, "brier_score": None, "reliability": []}
    p = np.array([j.probability for j in told], dtype=float)
    right = np.array([j.right for j in told], dtype=float)
    log, brier = proper_scores(p, right)
    return {
        "log_score": log,
        "brier_score": brier,
        "reliability": reliability(p, right),
    }


def proper_scores(p: np.ndarray, right: np.ndarray) -> tuple[float, float]:
    """Log score and Brier score of probabilities, less is better."""
    sure = np.clip(p, SUREST, 1.0 - SUREST)
    log = -np.where(right > 0, np.log(sure), np.log1p(-sure))
    return float(log.mean()), float(np.mean((p - right) ** 2))


def reliability(p: np.ndarray, right: np.ndarray) -> list[dict]:
    """Per bin of told probability: how often it was right."""
    rows = []
    for low, high in itertools.pairwise(_BINS):
        inside = (p >= low) & ((p < high) | (high == _BINS[-1]))
        if inside.any():
            told = {"from": low, "to": high, "told": float(p[inside].mean())}
            rows.append(told | share_of(right[inside]))
    return rows


def confusion(judged: list[Judged]) -> dict[str, dict[str, dict[str, int]]]:
    """By severity ("-" for none): counts of answers for each truth."""
    table: dict[str, dict[str, Counter]] = {}
    for j in sorted(judged, key=lambda j: j.expected):
        rows = table.setdefault(j.severity or "-", {})
        rows.setdefault(j.expected, Counter())[j.given] += 1
    return {
        s: {t: dict(sorted(c.items())) for t, c in rows.items()}
        for s, rows in table.items()
    }


def _row(j: Judged) -> dict:
    return {
        "case": j.name,
        "kind": j.kind,
        "severity": j.severity,
        "floors": j.floors,
        "truth": j.expected if j.kind != "outside" else j.truth["outside"][0],
        "answer": j.given,
        "possible": j.answers[1:],
        "probability": j.probability,
        "right": j.right,
    }


def _told(judged: list[Judged], key: str) -> list[float]:
    values = [getattr(j, key) for j in judged]
    return [value for value in values if value is not None]


def _of(statistic, values: list[float]) -> float | None:
    return float(statistic(values)) if values else None
