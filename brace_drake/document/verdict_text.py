"""The verdict in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from brace_drake.effects.registry import choice_words, find_effect
from brace_drake.report.words import parameter_text
from brace_drake.selection.thresholds import MATERIAL, WITHIN

# A number that is stated is told where it is off by more than this part, and by
# so many standard errors.
_STATED, _CLEAR = 0.1, 4.0
# Share of the gap from which on effects that close it explain it, not a part.
_EXPLAINED = 1.0 - MATERIAL
# Times the floor up to which a twin is said to be at its noise.
_AT_NOISE = 1.1
# Numbers beyond their tolerances that are named.
_MOST_FAR = 3


def verdict_sentence(
    name: str,
    verdict: dict,
    closed: float | None,
    moved: Sequence[dict],
    off: float | None = None,
) -> str:
    """What was found, what is certain of it, and what is left.

    Args:
        name: Of the campaign.
        verdict: Of the document, without its sentence.
        closed: Share of the gap that all effects close on validation runs.
        moved: Numbers known to a tolerance that the data move: name, unit,
            value and `deviations`.
        off: Times the floor that the twin is off on validation runs; None
            without any.
    """
    why = verdict["contradicted"]
    if why and not verdict["effects"]:
        return (
            f"There is a gap in {name}, and nothing that explains it is"
            f" confirmed: {why}."
        )
    if not verdict["gap"]:
        how = "the subject's parameters"
        far = _far_text(moved)
        if far:
            return (
                f"No effect is needed in {name}, but more than tolerances allow"
                f" for: with {how} fitted, {far}."
            )
        how += " and numbers within their tolerances" if moved else ""
        if off is not None and off > _AT_NOISE:
            return (
                f"No gap that tolerances do not allow for: with {how} fitted,"
                f" the twin of {name} is {off:.3g} times the noise floor off on"
                " validation runs, no more than a right twin may leave."
            )
        return (
            f"No gap: with {how} fitted, the twin reproduces {name} down to"
            " its noise."
        )
    left = verdict["unexplained"]
    rest = _rest_text(left)
    if not verdict["effects"]:
        text = f"There is a gap in {name}, and no effect in the library"
        text += " explains it"
        return f"{text}; {rest}." if rest else f"{text}."
    withdrawn = f" Withdrawn: {why}." if why else ""
    if verdict["outside_library"]:
        return f"{_partly_text(name, verdict, rest)}{withdrawn}"
    text, far = _explained_text(name, verdict, closed), _far_text(moved)
    text += f" Beside them {far}." if far else ""
    return f"{text}{withdrawn}"


def _far_text(moved: Sequence[dict]) -> str:
    """Numbers that are off by more than their tolerances allow; empty where
    none is.
    """
    far = [row for row in moved if abs(row["deviations"]) > WITHIN]
    if not far:
        return ""
    told = [off_text(row) for row in far[:_MOST_FAR]]
    if len(far) > _MOST_FAR:
        told.append(f"{len(far) - _MOST_FAR} more by more than {WITHIN:.0f}")
    return " and ".join(told)


def off_text(row: Mapping) -> str:
    """How far a number is from what the scenario says, and in tolerances."""
    value, unit = row["value"], row["unit"]
    name = parameter_text(row["name"], unit)
    if unit == "1":
        value, unit = 100.0 * value, "%"
    elif unit == "m":
        value, unit = 1e3 * value, "mm"
    return (
        f"{name} is off by {value:+.2g} {unit},"
        f" {abs(row['deviations']):.2g} of its tolerances"
    )


def _partly_text(name: str, verdict: dict, rest: str) -> str:
    """Effects that are certain beside something that the library has not."""
    rows = verdict["supported"]
    causes = " and ".join(_cause_text(row) for row in rows)
    shares = " and ".join(_share(row["closes"]) for row in rows)
    verb, explain = ("is", "explains") if len(rows) == 1 else ("are", "explain")
    sure = min(row["probability"] for row in rows)
    return (
        f"{causes[:1].upper()}{causes[1:]} {verb} there (p {sure:.2f}) and"
        f" {explain} {shares} of the gap in {name}; {rest}."
    )


def _explained_text(name: str, verdict: dict, closed: float | None) -> str:
    """Effects that explain the gap, as far as validation runs bear it out."""
    rows = verdict["supported"]
    causes = " and ".join(_cause_text(row) for row in rows)
    partly = "partly " if closed is not None and closed < _EXPLAINED else ""
    text = f"The gap in {name} is {partly}explained by {causes}"
    if verdict["ambiguous_with"]:
        others = " or ".join(map(_title, verdict["ambiguous_with"]))
        text += f", or as well by {others}, which these runs cannot tell apart"
    if closed is None:
        return f"{text}; no validation run confirms it."
    them = "it" if len(rows) == 1 else "them"
    return (
        f"{text}; adding {them} closes {_share(closed)} of the gap on the"
        " validation runs."
    )


def _title(candidate: str) -> str:
    """Effects joined by + in words."""
    return " and ".join(map(_cause_title, candidate.split("+")))


def _cause_title(cause: str) -> str:
    """Of an effect, with the place where it is."""
    name, _, at = cause.removesuffix(")").partition(" (")
    title = find_effect(name).title
    return f"{title}: {at}" if at else title


def controller_text(block_tests: Sequence[dict]) -> str:
    """What is said of a controller that does not follow its own law on recorded
    inputs: no effect of the machine makes that. Empty where it does.
    """
    for row in block_tests:
        if row["block"] == "controller" and not row["acquitted"]:
            return (
                f" The commands are {row['normalised_rms']:.3g} times their"
                " floor off what the controller makes of the recorded readings:"
                " something enters between controller and drive, or another"
                " controller ran."
            )
    return ""


def stated_text(stated: Mapping[str, float], estimates: Sequence) -> str:
    """Numbers of the machine that are not what was stated; empty where all are.

    Args:
        stated: `nominal` of the campaign, by name.
        estimates: With name, value and standard error.
    """
    told = []
    for name, nominal in stated.items():
        quantity = name.split("_")[0]
        for p in estimates:
            if p.name.split("_")[0] != quantity or nominal <= 0.0:
                continue
            away = abs(p.value - nominal)
            error = p.standard_error or 0.0
            if away > max(_STATED * nominal, _CLEAR * error):
                told.append(f"{quantity} {p.value / nominal:.3g} times")
    if not told:
        return ""
    return f" Fitted anew, it has {' and '.join(told)} what was stated."


def _share(share: float) -> str:
    # More than all is noise.
    if share >= 1.0:
        return "100 %"
    if share > 0.9995:
        return "more than 99.9 %"
    return f"{100.0 * max(share, 0.0):.1f} %"


def _rest_text(left: dict) -> str:
    """What is left, in words; empty where that is nothing."""
    if not left["share"]:
        return ""
    text = f"{_share(left['share'])} is left"
    if left["block"]:
        text += f", in {left['block']}"
    if left["description"]:
        text += f", and {left['description']}"
    return text


def _cause_text(row: dict) -> str:
    values = ", ".join(_value_text(p) for p in row["parameters"])
    return f"{row['title']} ({values})"


def _value_text(row: dict) -> str:
    """A fitted parameter as a reader has it: clearance 2.033 mm."""
    name, unit, value = row["name"], row["unit"], row["value"]
    words = choice_words(name, value)
    if words is not None:
        return words
    if unit == "m":
        value, shown = 1e3 * value, "mm"
    else:
        shown = "" if unit == "1" else unit
    return f"{parameter_text(name, unit)} {value:.4g} {shown}".strip()
