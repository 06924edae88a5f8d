"""Scores answers against the truth of withheld cases."""

from __future__ import annotations

import itertools
import json
import math
from collections import Counter
from pathlib import Path

import numpy as np
import yaml

from brace_drake.withheld.answer import (
    ANSWERS,
    ANSWERS_FORMAT,
    COMMITMENT,
    AnswerError,
    digest_of,
    read_seals,
)
from brace_drake.withheld.faults import SEVERITIES
from brace_drake.withheld.seals import (
    SEALS,
    VAULT_FORMAT,
    SealError,
    check_seal,
)
from brace_drake.withheld.shares import Share, share_of
from brace_drake.withheld.verdicts import Judged

SCORE_FORMAT = "brace-score/1"
_BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 1.0)
# A probability nearer to 0 or 1 than this is held to be no surer.
_SUREST = 1e-3


def load_judged(folder: Path, vault: Path, answers: Path) -> list[Judged]:
    """Truth beside answers, once seals and commitment have been verified.

    Raises:
        SealError: Truth or answers are not those promised.
        AnswerError: A file is missing or of another format.
    """
    seals = read_seals(folder)
    truths = _read_json(Path(vault), VAULT_FORMAT)["cases"]
    given = _read_json(Path(answers) / ANSWERS, ANSWERS_FORMAT)["cases"]
    _check_commitment(Path(folder), Path(answers))
    for other, what in ((truths, "vault"), (given, "answers")):
        if set(other) != set(seals):
            raise SealError(f"{what}: not the cases of {folder}")
    judged = []
    for name, promised in seals.items():
        truth = truths[name]["truth"]
        check_seal(name, truth, truths[name]["salt"], promised)
        answer = given[name]
        judged.append(Judged(name, truth, answer["verdict"], answer["closed"]))
    return judged


def score(judged: list[Judged], least: float) -> dict:
    """All figures of merit.

    Args:
        judged: The cases.
        least: Floors above which a gap counts as detectable.
    """
    single = [j for j in judged if j.kind == "single"]
    clear = [j for j in single if j.is_detectable(least)]
    pair = [j for j in judged if j.kind == "pair"]
    none = [j for j in judged if j.kind == "none"]
    outside = [j for j in judged if j.kind == "outside"]
    wrong = [j for j in judged if j.kind != "none"]
    accused = [j for j in judged if j.given == "outside"]
    shares = {
        "answered right": share_of([j.right for j in judged]),
        "no answer": share_of([j.verdict is None for j in judged]),
        "false alarms": share_of([j.given != "none" for j in none]),
        "singles: first answer": share_of([j.right for j in single]),
        "detectable singles: first answer": share_of([j.right for j in clear]),
        "detectable singles: coverage": share_of([j.covered for j in clear]),
        "pairs: both named": share_of([j.right for j in pair]),
        "pairs, each detectable: both named": share_of(
            [j.right for j in pair if j.is_each_detectable(least)]
        ),
        "pairs: at least one named": share_of(
            [bool(j.named & set(j.truth["effects"])) for j in pair]
        ),
        "outside: recall": share_of([j.right for j in outside]),
        "outside: precision": share_of([j.kind == "outside" for j in accused]),
        "library effects called outside": share_of(
            [j.given == "outside" for j in single + pair]
        ),
        "blocks: exactly those at fault": share_of(
            [j.blocks_right for j in wrong]
        ),
        "detectable gaps: blocks at fault": share_of(
            [j.accuses_rightly for j in wrong if j.is_detectable(least)]
        ),
    }
    for severity in SEVERITIES:
        these = [j.right for j in single if j.severity == severity]
        shares[f"singles, {severity}: first answer"] = share_of(these)
    return {
        "format": SCORE_FORMAT,
        "cases": len(judged),
        "detectable_floors": least,
        "shares": {name: s.document() for name, s in shares.items()},
        "answers_per_case": _mean([len(j.answers) for j in clear if j.answers]),
        "gap_closed_median": _median(
            [j.closed for j in judged if j.right and j.closed is not None]
        ),
        **probability_scores(judged),
        "confusion": confusion(judged),
        "each": [_row(j) for j in judged],
    }


def probability_scores(judged: list[Judged]) -> dict:
    """Log score and Brier score (less is better), and the reliability."""
    told = [j for j in judged if j.probability is not None]
    p = np.array([j.probability for j in told], dtype=float)
    right = np.array([j.right for j in told], dtype=float)
    if not told:
        return {"log_score": None, "brier_score": None, "reliability": []}
    log, brier = proper_scores(p, right)
    return {
        "log_score": log,
        "brier_score": brier,
        "reliability": reliability(p, right),
    }


def proper_scores(p: np.ndarray, right: np.ndarray) -> tuple[float, float]:
    """Log score and Brier score of probabilities, less is better."""
    sure = np.clip(p, _SUREST, 1.0 - _SUREST)
    log = -np.where(right > 0, np.log(sure), np.log1p(-sure))
    return float(log.mean()), float(np.mean((p - right) ** 2))


def reliability(p: np.ndarray, right: np.ndarray) -> list[dict]:
    """Per bin of told probability: how often it was right."""
    rows = []
    for low, high in itertools.pairwise(_BINS):
        inside = (p >= low) & ((p < high) | (high == _BINS[-1]))
        if not inside.any():
            continue
        share = Share(int(right[inside].sum()), int(inside.sum()))
        rows.append(
            {
                "from": low,
                "to": high,
                "told": float(p[inside].mean()),
                **share.document(),
            }
        )
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
    faults = j.truth["floors"]["faults"]
    return {
        "case": j.name,
        "kind": j.kind,
        "severity": j.severity,
        "floors": faults["refitted"] if faults else None,
        "truth": j.expected if j.kind != "outside" else j.truth["outside"][0],
        "answer": j.given,
        "possible": j.answers[1:],
        "probability": j.probability,
        "right": j.right,
    }


def _mean(values: list[float]) -> float | None:
    return math.fsum(values) / len(values) if values else None


def _median(values: list[float]) -> float | None:
    return float(np.median(values)) if values else None


def _check_commitment(folder: Path, answers: Path) -> None:
    path = answers / COMMITMENT
    try:
        promised = yaml.safe_load(path.read_text())
        expected = promised["answers_sha256"], promised["seals_sha256"]
    except OSError as error:
        raise AnswerError(f"{path}: {error.strerror}") from error
    except (yaml.YAMLError, KeyError, TypeError) as error:
        raise AnswerError(f"{path}: no commitment") from error
    if digest_of(answers / ANSWERS) != expected[0]:
        raise SealError(f"{answers / ANSWERS}: changed since the commitment")
    if digest_of(folder / SEALS) != expected[1]:
        raise SealError(f"{folder / SEALS}: changed since the commitment")


def _read_json(path: Path, wanted: str) -> dict:
    try:
        document = json.loads(path.read_text())
        found = document["format"]
    except OSError as error:
        raise AnswerError(f"{path}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise AnswerError(f"{path}: not a {wanted} document") from error
    if found != wanted:
        raise AnswerError(f"{path}: format {found!r}, expected {wanted!r}")
    return document
