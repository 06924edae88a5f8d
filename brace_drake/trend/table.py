"""A trend as a table for spreadsheets, and as text for a terminal."""

from __future__ import annotations

from brace_drake.core.csv_text import csv_text
from brace_drake.report.words import (
    decimals_for,
    fixed,
    percent,
    scale_of,
    significant,
    times,
)
from brace_drake.trend.sentences import number_name

COLUMNS = (
    "session",
    "folder",
    "date",
    "of",
    "name",
    "unit",
    "value",
    "standard_error",
    "lower95",
    "upper95",
    "left_out",
)


def format_csv(document: dict) -> str:
    """One row for each number of each session; COLUMNS as head."""
    rows, sessions = [], document["sessions"]
    for row in [*document["parameters"], document["gap"]]:
        for point in row["points"]:
            session = sessions[point["session"]]
            cells = {key: point.get(key) for key in COLUMNS}
            cells |= {
                "session": point["session"] + 1,
                "folder": session["folder"],
                "date": session["date"],
                "of": row["of"],
                "name": row["name"],
                "unit": row["unit"],
            }
            rows.append(cells)
    for i, session in enumerate(sessions):
        ends = session["closed_interval"] or (None, None)
        shown = {"name": "closed", "of": "twin", "value": session["closed"]}
        shown |= {"lower95": ends[0], "upper95": ends[1]}
        shown |= {"session": i + 1, "folder": session["folder"]}
        rows.append(shown | {"date": session["date"]})
    return csv_text(COLUMNS, rows)


def format_text(document: dict) -> str:
    """Sessions, numbers and alarms, for people at a terminal."""
    lines = [document["sentence"], f"times: {document['time']['source']}", ""]
    lines += _session_lines(document)
    lines += ["", *_number_lines(document), ""]
    lines += [f"alarm: {alarm['sentence']}" for alarm in document["alarms"]]
    return "\n".join([*lines, document["level"]["statement"]])


def _session_lines(document: dict) -> list[str]:
    sessions = document["sessions"]
    width = max(len(s["name"]) for s in sessions)
    lines = [
        f"    {'session':{width}}  {'date':16}  {'gap':>6} {'closed':>7}"
        "  verdict"
    ]
    for i, s in enumerate(sessions, start=1):
        date = (s["date"] or "-").replace("T00:00:00", "")[:16]
        lines.append(
            f"{i:3d} {s['name']:{width}}  {date:16}"
            f"  {times(s['gap_before']):>6} {percent(s['closed']):>7}"
            f"  {verdict_word(s)} ({s['probability']:.2f})"
        )
    return lines


def verdict_word(session: dict) -> str:
    """A verdict in a word or two."""
    if session["recording_fault"]:
        return "recording fault"
    if not session["gap"]:
        return "no gap"
    named = " + ".join(session["effects"])
    if session["outside_library"]:
        return f"{named} + rest" if named else "outside the library"
    return named


def _number_lines(document: dict) -> list[str]:
    rows = [*document["parameters"], document["gap"]]
    width = max(len(number_name(r)) for r in rows)
    lines = [
        f"{'number':{width}}  {'mean':>10}  {'change over the span':>24}"
        f"  {'chi2/dof':>8}  {'least p':>8}  alarm"
    ]
    for row in rows:
        name, tests = number_name(row), row["tests"]
        if tests is None:
            lines.append(f"{name:{width}}  not tested: {row['note']}")
            continue
        cells = number_cells(row)
        lines.append(
            f"{name:{width}}  {cells['mean']:>10}  {cells['change']:>24}"
            f"  {cells['ratio']:>8}  {cells['p']:>8}  {row['alarm'] or '-'}"
        )
    lines.append("p: corrected for all tests of the table")
    return lines


def number_cells(row: dict) -> dict[str, str]:
    """Mean, change with 95 % interval, chi-square and least p, as text."""
    tests, unit = row["tests"], row["unit"]
    mean, trend = tests["mean"]["value"], tests["trend"]
    factor, shown = scale_of(unit, [mean])
    change = "–"
    if trend is not None:
        own = trend["with_scatter"] or trend["stated"]
        span = abs(trend["span"]) * factor
        middle = own["value"] * span
        low, high = (own[k] * span for k in ("lower95", "upper95"))
        decimals = decimals_for((high - low) / 4.0, middle)
        low, middle, high = (fixed(v, decimals) for v in (low, middle, high))
        change = f"{middle} ({low} to {high})"
    constancy = tests["constancy"]
    parts = (constancy, tests["step"], trend or {})
    found = [
        p["p_corrected"] for p in parts if p.get("p_corrected") is not None
    ]
    ratio = constancy["chi2"] / constancy["degrees_of_freedom"]
    return {
        "mean": f"{significant(mean * factor, 4)} {shown}".rstrip(),
        "unit": shown,
        "change": change,
        "ratio": significant(ratio, 2),
        "p": significant(min(found), 2) if min(found) >= 1e-6 else "< 1e-6",
    }
