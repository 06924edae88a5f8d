"""From what a diagnosis comes: when, by which command, of which recordings."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import dataclass

from brace_drake.diagnosis import Diagnosis
from brace_drake.identification.gap import RunComparison, rms_gap


@dataclass(frozen=True)
class Origin:
    """What a diagnosis does not know of itself.

    Attributes:
        command: That makes it again; None where it was called from Python.
        made: When; None: now, UTC.
    """

    command: str | None = None
    made: datetime.datetime | None = None


def origin_rows(d: Diagnosis, origin: Origin) -> dict:
    """Command and times, as the provenance lists them."""
    made = origin.made or datetime.datetime.now(datetime.UTC)
    return {
        "command": origin.command,
        "diagnosed": made.isoformat(timespec="seconds"),
        "recorded": d.campaign.recorded or None,
    }


def run_rows(d: Diagnosis) -> list[dict]:
    """Every run: what it is, and how far the twins are off, × floor.

    `before`, `after` and `with_law` are None where a run was not replayed,
    `after` and `with_law` also where nothing was added.
    """
    compared = {
        c.prepared.run.file: c for c in (*d.fit_runs, *d.validation_runs)
    }
    by_law = {c.prepared.run.file: c for c in d.law.runs} if d.law else {}
    rows = []
    for run in d.campaign.runs:
        last = float(run.time_s[-1] - run.time_s[0])
        rows.append(
            {
                "run": run.name,
                "file": run.file,
                "motion": run.motion,
                "split": run.split,
                "contact": run.contact,
                "repeat_of": run.repeat_of,
                "duration_s": last,
                "samples": len(run.time_s),
                "rate_hz": (len(run.time_s) - 1) / last if last else None,
                "before": _gap(compared, run.file, "before"),
                "after": _gap(compared, run.file, "after"),
                "with_law": _gap(by_law, run.file, "after"),
            }
        )
    return rows


def _gap(
    compared: Mapping[str, RunComparison], file: str, which: str
) -> float | None:
    found = compared.get(file)
    if found is None or getattr(found, which) is None:
        return None
    return rms_gap([found], which)
