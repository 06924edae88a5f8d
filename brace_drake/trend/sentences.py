"""What a trend says, in sentences."""

from __future__ import annotations

from brace_drake.report.words import (
    decimals_for,
    fixed,
    parameter_text,
    percent,
    scale_of,
    significant,
)
from brace_drake.trend.alarms import (
    APPEARS,
    DISAPPEARS,
    DRIFT,
    GROWS,
    MOVED,
    SCATTER,
    STEP,
)
from brace_drake.trend.grouping import Timeline
from brace_drake.trend.series import GAP

_YEAR = 365.25
_RARE = 1e-6


def number_name(row: dict) -> str:
    """A number as a reader knows it: "contact stiffness", or of an effect."""
    if row["name"] == GAP:
        return "gap"
    own = parameter_text(row["name"], row["unit"])
    return own if row["of"] == "subject" else f"{own} of {row['of']}"


def amount(own: dict, unit: str, times: float = 1.0) -> str:
    """A coefficient of a document, times a factor, with half of its 95 %
    interval and unit, to digits that it deserves.
    """
    value = times * own["value"]
    half = 0.5 * times * (own["upper95"] - own["lower95"])
    factor, shown = scale_of(unit, [value, half])
    decimals = decimals_for(half * factor, value * factor)
    text = fixed(value * factor, decimals)
    return f"{text} ± {fixed(half * factor, decimals)} {shown}".rstrip()


def probability(p: float) -> str:
    """As "p 0.003", no smaller than makes sense."""
    return "p < 10⁻⁶" if p < _RARE else f"p {significant(p, 2)}"


def series_sentence(row: dict, unit: str) -> str:
    """What a number does over the sessions."""
    name, tests = number_name(row), row["tests"]
    name = name[:1].upper() + name[1:]
    if tests is None:
        return f"{name} is not tested: {row['note']}."
    shown = "floors" if row["name"] == GAP else row["unit"]
    step, alarm = tests["step"], row["alarm"]
    if alarm == DRIFT:
        return f"{name} drifts: {_slope(row, shown, unit)}."
    if alarm == STEP:
        own = step["with_scatter"]
        size = amount(own, shown)
        p = probability(step["p_corrected_with_scatter"])
        return (
            f"{name} steps by {size} before session"
            f" {step['before_session_with_scatter'] + 1} ({p})."
        )
    if alarm == MOVED:
        own = step["stated"]
        size = amount(own, shown)
        return (
            f"{name} differs by {size} from session {row['at'] + 1} on, which"
            f" is more than its intervals ({probability(_least(tests))}). With"
            f" {tests['sessions']} sessions a change cannot be told from a"
            " scatter between sessions."
        )
    if alarm == SCATTER:
        size = _length(tests["scatter"]["value"], shown)
        ratio = significant(tests["constancy"]["birge_ratio"], 2)
        return (
            f"{name} scatters from session to session by {size} (one standard"
            f" deviation): its intervals would have to be {ratio} times as"
            f" wide ({probability(_least(tests))}). Neither a drift nor a step"
            " stands out of that scatter."
        )
    if alarm == GROWS:
        own = step["stated"]
        size = amount(own, "")
        return (
            f"The gap grows: from session {row['at'] + 1} on it is"
            f" {size} noise floors larger ({probability(_least(tests))})."
        )
    return f"{name} shows no change beyond its uncertainty."


def _length(value: float, unit: str) -> str:
    """A size of which two digits count."""
    factor, shown = scale_of(unit, [value])
    return f"{significant(value * factor, 2)} {shown}".rstrip()


def _least(tests: dict) -> float:
    """The smallest corrected probability of a number's tests."""
    parts = (tests["constancy"], tests["step"], tests["trend"] or {})
    found = [part.get("p_corrected") for part in parts]
    return min(p for p in found if p is not None)


def _slope(row: dict, shown: str, unit: str) -> str:
    trend = row["tests"]["trend"]
    own = trend["with_scatter"]
    factor, per = (_YEAR, "year") if unit == "d" else (1.0, "session")
    size = amount(own, shown, factor)
    p = probability(trend["p_corrected_with_scatter"])
    return f"{size} per {per} ({p})"


def effect_sentence(row: dict) -> str:
    """Whether an effect comes or goes."""
    named = [n for n in row["named"] if n is not None]
    title = row["title"] or row["name"]
    title = title[:1].upper() + title[1:]
    count = f"{sum(named)} of {len(named)} sessions that tell"
    if row["at"] is None:
        return f"{title} is named in {count}: no change."
    if row["alarm"] is None:
        return (
            f"{title} is named in {count}; wrong verdicts alone could do that"
            f" ({probability(row['p_corrected'])})."
        )
    gone = row["alarm"] == DISAPPEARS
    word = "is no longer named" if gone else "is named"
    return (
        f"{title} {word} from session {row['at'] + 1} on"
        f" ({probability(row['p_corrected'])})."
    )


def state_level(level: float, timeline: Timeline) -> str:
    """What the false-alarm level means, and what few sessions cannot say."""
    n = len(timeline.sessions)
    text = (
        "Where nothing changes, and intervals and probabilities of the"
        f" diagnoses are right, at most {percent(level)} of such pages raise"
        " any alarm."
    )
    if n < 4:
        return text + (
            f" {n} sessions cannot tell a change from a scatter between"
            " sessions; four or more can."
        )
    return text + (
        " A drift or a step is called so only where it stands out of the"
        " scatter between sessions."
    )


def summary_sentence(document: dict) -> str:
    """The headline: how many alarms, and of what."""
    alarms, n = document["alarms"], len(document["sessions"])
    if not alarms:
        return f"No change beyond its uncertainty in {n} sessions."
    by_kind: dict[str, list[str]] = {}
    rows = {(r["of"], r["name"]): r for r in document["parameters"]}
    for alarm in alarms:
        row = rows.get((alarm["of"], alarm["name"]))
        name = number_name(row) if row else alarm["name"].replace("_", " ")
        by_kind.setdefault(alarm["kind"], []).append(name)
    parts = [
        f"{', '.join(names[:-1])} and {names[-1]} {_KINDS[kind][1]}"
        if names[1:]
        else f"{names[0]} {_KINDS[kind][0]}"
        for kind, names in by_kind.items()
    ]
    return f"In {n} sessions: {'; '.join(parts)}."


# What one number does, and what several do.
_KINDS = {
    DRIFT: ("drifts", "drift"),
    STEP: ("steps", "step"),
    MOVED: ("moves by more than its intervals", "move by more than theirs"),
    SCATTER: ("scatters beyond its intervals", "scatter beyond theirs"),
    GROWS: ("grows", "grow"),
    APPEARS: ("appears", "appear"),
    DISAPPEARS: ("disappears", "disappear"),
}
