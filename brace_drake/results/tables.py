"""The documents of diagnosis, fit and plan as plain tables: lists of rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Row = dict[str, Any]
Tables = dict[str, list[Row]]

# Tables of a diagnosis that its document has as rows already.
_WHERE = ("blocks", "attribution", "channels", "phases", "bands")


def diagnosis_tables(document: Mapping[str, Any]) -> Tables:
    """Tables of a diagnosis.

    causes: every candidate, ranked. parameters: of the effects found, with
    intervals. subject: its parameters. supported: the effects that are
    certain. budget: the gap by channel, phase and band. blocks, attribution,
    channels, phases, bands: the gap by one of them. validation: before and
    after on validation runs, channel by channel. tolerances: numbers that the
    data move. left: what remains.
    """
    where, shrink = document["where"], document["shrink"] or {}
    verdict = document["verdict"]
    return {
        "causes": [_cause(row) for row in document["causes"]],
        "parameters": [
            {"effect": row["effect"], **parameter}
            for row in verdict["supported"]
            for parameter in row["parameters"]
        ],
        "subject": [dict(p) for p in document["subject"]["parameters"]],
        "supported": [
            _flat(row, "closes", "parameters") for row in verdict["supported"]
        ],
        "budget": [dict(row) for row in where["cube"]],
        **{name: [_joined(row) for row in where[name]] for name in _WHERE},
        "validation": [dict(row) for row in shrink.get("channels", ())],
        "tolerances": [dict(row) for row in document["tolerances"]],
        "left": [dict(row) for row in document["left"]],
    }


def fit_tables(document: Mapping[str, Any]) -> Tables:
    """parameters: of the subject. correlation: of the estimates."""
    names = [p["name"] for p in document["parameters"]]
    return {
        "parameters": [dict(p) for p in document["parameters"]],
        "correlation": [
            {"parameter": name, **dict(zip(names, row, strict=True))}
            for name, row in zip(names, document["correlation"], strict=True)
        ],
    }


def plan_tables(document: Mapping[str, Any]) -> Tables:
    """effects: what each shows. pairs: which are not told apart. cosines:
    between the signatures. undetermined: parameters that stay open.
    """
    names = [row["effect"] for row in document["effects"]]
    return {
        "effects": [
            {k: v for k, v in row.items() if k != "parameters"}
            for row in document["effects"]
        ],
        "pairs": [
            {
                "first": row["effects"][0],
                "second": row["effects"][1],
                "cosine": row["cosine"],
                "reason": row["reason"],
            }
            for row in document["pairs"]
        ],
        "cosines": [
            {"effect": name, **dict(zip(names, row, strict=True))}
            for name, row in zip(names, document["cosines"], strict=True)
        ],
        "undetermined": [dict(row) for row in document["undetermined"]],
    }


def _cause(row: Mapping[str, Any]) -> Row:
    """A candidate on one line: its gap on validation runs, its parameters as
    name and value.
    """
    seen = row["validation"] or dict.fromkeys(("gap", "lower95", "upper95"))
    out = {
        k: v for k, v in row.items() if k not in ("validation", "parameters")
    }
    out |= {f"validation_{k}": v for k, v in seen.items()}
    # Joint fits may have two parameters of one name: effect by effect.
    out["parameters"] = [(p["name"], p["value"]) for p in row["parameters"]]
    return out


def _flat(row: Mapping[str, Any], share: str, *left_out: str) -> Row:
    """A row with the ends of a share's interval beside it."""
    low, high = row[f"{share}_interval"] or (None, None)
    out = {
        k: v
        for k, v in row.items()
        if k not in left_out and k != f"{share}_interval"
    }
    return out | {f"{share}_lower95": low, f"{share}_upper95": high}


def _joined(row: Mapping[str, Any]) -> Row:
    """A row whose lists are text."""
    return {
        k: ", ".join(map(str, v)) if isinstance(v, list) else v
        for k, v in row.items()
    }
