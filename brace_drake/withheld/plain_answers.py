"""Answers of any method: one JSON file, a few keys for each case.

    {"format": "brace-benchmark-answers/1", "method": "my method",
     "cases": {"case000": {"effects": ["backlash"], "outside": false,
                           "blocks": ["actuation"], "probability": 0.8,
                           "closed": 0.7, "seconds": 12.5}}}

`effects` are names of the library, [] for none, null where the method names
none at all; `outside` says that something is wrong that the library has not.
No effect and nothing outside is no gap. All else may be left out: blocks are
then those of the effects. `closed` is the share of the gap that is gone on the
runs with `split: validation`, `seconds` the CPU time of the case.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from pathlib import Path

from brace_drake.core.errors import suggest
from brace_drake.core.reading import LoadJson
from brace_drake.withheld.faults import FAULTS, OUTSIDE
from brace_drake.withheld.seals import AnswerError

PLAIN_FORMAT = "brace-benchmark-answers/1"
BLOCK_OF = {fault.name: fault.block for fault in FAULTS}
_BLOCKS = sorted({fault.block for fault in (*FAULTS, *OUTSIDE)})
_KEYS = ("effects", "outside", "blocks", "probability", "closed", "seconds")


def read_plain(path: Path) -> tuple[str, dict[str, dict]]:
    """Name of the method, and what `answer_cases` would give for each case.

    Raises:
        AnswerError: The file is missing, of another format, or an answer has
            a value that none can have.
    """
    document = LoadJson(path, AnswerError)
    cases = document.get("cases") if isinstance(document, dict) else None
    if not isinstance(cases, dict) or document.get("format") != PLAIN_FORMAT:
        raise AnswerError(f"{path}: not a {PLAIN_FORMAT} document")
    method = document.get("method") or path.stem
    if not isinstance(method, str) or not method.isprintable():
        raise AnswerError(f"{path}: method is {method!r}, not a word")
    return method, {
        str(name): _answer(f"{path}: {name}", row)
        for name, row in cases.items()
    }


def _answer(where: str, row: object) -> dict:
    if not isinstance(row, dict):
        raise AnswerError(f"{where}: not a map of {', '.join(_KEYS)}")
    _refuse_unknown(f"{where}: no key", row, _KEYS)
    if not {"effects", "outside"} & set(row):
        raise AnswerError(f"{where}: says neither effects nor outside")
    effects = row.get("effects", [])
    if effects is not None:
        effects = _names(where, "effects", effects, tuple(BLOCK_OF))
    outside = row.get("outside", False)
    if not isinstance(outside, bool):
        raise AnswerError(f"{where}: outside is {outside!r}, not true or false")
    blocks = row.get("blocks")
    if blocks is None:
        blocks = sorted({BLOCK_OF[name] for name in effects or ()})
    verdict = {
        "gap": effects is None or bool(effects) or outside,
        "effects": effects,
        "outside_library": outside,
        "blocks": _names(where, "blocks", blocks, _BLOCKS),
        "probability": _number(where, row, "probability", 0.0, 1.0),
    }
    closed = _number(where, row, "closed", -math.inf, 1.0)
    seconds = _number(where, row, "seconds", 0.0, math.inf)
    return {"verdict": verdict, "closed": closed, "seconds": seconds}


def _names(
    where: str, key: str, value: object, known: Collection[str]
) -> list[str]:
    if not isinstance(value, list):
        raise AnswerError(f"{where}: {key} is {value!r}, not a list of names")
    _refuse_unknown(f"{where}: {key}: no", value, known)
    if len({*value}) < len(value):
        raise AnswerError(f"{where}: {key} names one twice")
    return value


def _refuse_unknown(what: str, names: Iterable, known: Collection[str]) -> None:
    for name in names:
        if not isinstance(name, str) or name not in known:
            raise AnswerError(f"{what} {name!r}{suggest(name, known)}")


def _number(
    where: str, row: dict, key: str, low: float, high: float
) -> float | None:
    value = row.get(key)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise AnswerError(f"{where}: {key} is {value!r}, not a number")
    if not low <= value <= high:
        raise AnswerError(
            f"{where}: {key} is {value:g}, allowed {low:g} to {high:g}"
        )
    return float(value)
