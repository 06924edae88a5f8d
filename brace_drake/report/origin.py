"""Provenance of a page: from what it was made, when, and by what."""

from __future__ import annotations

from brace_drake.report.words import (
    NOTHING,
    fixed,
    over_floor,
    significant,
    times,
    to_text,
)

# Keys of the provenance that are mean squares above the floor's.
_MISFITS = ("misfit", "level")
# Keys that are rows of their own, told in words.
_TOLD = ("command", "diagnosed", "recorded", "scenario", "data_sha256")


def view_origin(diagnosis: dict) -> dict:
    """Facts in words, runs, and the numbers that a diagnosis rests on."""
    provenance = diagnosis["provenance"]
    return {
        "facts": _facts(diagnosis, provenance),
        "runs": [_run_row(row) for row in diagnosis["runs"]],
        "numbers": _numbers(provenance),
    }


def _facts(diagnosis: dict, provenance: dict) -> list[tuple[str, str]]:
    scenario = provenance["scenario"]
    file = scenario["file"] or "the one that comes with the package"
    if scenario["named_by"] not in ("caller", "package"):
        file += f", named by {scenario['named_by']}"
    return [
        ("command", provenance["command"] or "called from Python"),
        ("diagnosed", provenance["diagnosed"]),
        ("recorded", provenance["recorded"] or "not stated in campaign.yaml"),
        ("campaign", diagnosis["campaign"]),
        ("data, SHA-256", provenance["data_sha256"]),
        ("scenario", file),
        ("scenario, SHA-256", scenario["sha256"] or NOTHING),
    ]


def _run_row(row: dict) -> dict:
    rate = row["rate_hz"]
    return row | {
        "duration": f"{fixed(row['duration_s'], 2)} s",
        "rate": NOTHING if rate is None else f"{significant(rate, 5)} Hz",
        "gaps": [times(row[k]) for k in ("before", "after", "with_law")],
    }


def _numbers(provenance: dict) -> list[tuple[str, str]]:
    """Misfits as multiples of the floor, the others as they are."""
    rows = []
    for name, value in provenance.items():
        if name in _TOLD:
            continue
        words = name.replace("_", " ")
        if isinstance(value, dict):
            rows += [(f"{words}: {k}", to_text(v)) for k, v in value.items()]
        elif name in _MISFITS:
            rows.append((words, f"{over_floor(value)} × floor"))
        else:
            rows.append((words, to_text(value)))
    return rows
