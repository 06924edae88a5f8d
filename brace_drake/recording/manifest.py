"""The campaign.yaml of a campaign: what was recorded, run by run."""

from __future__ import annotations

import math
from collections.abc import Collection
from pathlib import Path
from posixpath import isabs, normpath

from brace_drake.core.errors import ReadError, quoted, suggest
from brace_drake.core.reading import parse_yaml
from brace_drake.recording.columns import DEVICES, Device
from brace_drake.recording.fields import (
    DURATION,
    NOT_NEGATIVE,
    POSITIVE,
    RATE,
    RECORDED,
    SUBJECT,
    SWITCH,
    TEXT,
    WHAT_FOR,
    Fault,
    Field,
    take,
)
from brace_drake.recording.findings import Problem, error, warning
from brace_drake.recording.ports import parse_ports
from brace_drake.recording.recording import Campaign, Run, ScenarioFile

MANIFEST = "campaign.yaml"
FORMAT = "brace-campaign/1"
# Fields that every campaign has, and those of each run.
_HEAD = {
    "format": Field(repr(FORMAT), lambda v: v == FORMAT),
    "device": Field(
        "one of " + ", ".join(map(repr, DEVICES)),
        lambda v: isinstance(v, str) and v in DEVICES,
    ),
    "rate_hz": RATE,
    "runs": Field("a list of runs", lambda v: isinstance(v, list) and v != []),
    "settled_s": DURATION,
    "scenario": Field(
        "a path relative to the campaign's folder",
        lambda v: TEXT.accepts(v) and not isabs(v.replace("\\", "/")),
        required=False,
    ),
    "recorded": RECORDED,
    "subject": SUBJECT,
}
_RUN = {
    "file": TEXT,
    "contact": SWITCH,
    "motion": TEXT,
    "repeat_of": TEXT,
    "split": WHAT_FOR,
}
_NEEDED = ("file", "contact", "motion", "split")
# Keys of some devices, and what of a device's declaration makes it one.
_OF = {name: name for name in ("nominal", "control", "stages")}
_OF["diagram"] = "has_ports"
_KEYS = (*_HEAD, *_OF)
# What a recorder notes of a run beside.
NOTES = (
    *("complete", "begun", "stopped", "lost_messages", "bad_frames"),
    *("bridged_ticks", "unanswered_ticks", "latency_us_50_99_999"),
)
# Names that are not alike and mean the same.
_MEANT = {"date": "recorded"}
# Unknown keys beyond these are not named.
_MOST_NAMES = 5


def parse_manifest(data: bytes) -> tuple[Campaign | None, list[Problem]]:
    """Parses campaign.yaml.

    Returns:
        What could be used of it, its runs without channels; None when it is
        no YAML mapping; and every problem found.
    """
    try:
        content = parse_yaml(data)
    except ReadError as e:
        return None, [error(MANIFEST, str(e))]
    head, faults = take(content, _HEAD)
    name = head.get("device", "")
    device = DEVICES.get(name, Device({}))
    problems = _unknown(content, _keys_of(device) if name else _KEYS)
    numbers = {}
    for section in ("nominal", "control"):
        declared = getattr(device, section)
        # A controller need not be described.
        if declared and not (section == "control" and not content.get(section)):
            numbers[section], found = take_numbers(content, section, device)
            faults += found
            problems += _unknown(content.get(section), declared, section)
    stages: list[int] = []
    if device.stages:
        taken, found = take(content, {"stages": _neighbours(device.stages)})
        stages, faults = taken.get("stages", []), faults + found
    ports = None
    if device.has_ports:
        ports, found = parse_ports(content.get("diagram"))
        faults += found
    problems += [_error_of(fault) for fault in faults]
    settled_s = float(head.get("settled_s", 0.0))
    campaign = Campaign(
        path=Path(),
        device=name,
        rate_hz=float(head.get("rate_hz", math.nan)),
        subject=str(content.get("subject") or ""),
        runs=_parse_runs(
            head.get("runs", []), settled_s, problems, _needed(device)
        ),
        stages=tuple(stages),
        ports=ports,
        scenario=ScenarioFile(head["scenario"]) if "scenario" in head else None,
        **_recorded(head),
        **numbers,
    )
    return campaign, problems


def _keys_of(device: Device) -> list[str]:
    """Keys that are read of a campaign of a device."""
    return [k for k in _KEYS if k not in _OF or getattr(device, _OF[k])]


def _recorded(head: dict) -> dict:
    """When a campaign was recorded, or what its device has told of itself."""
    said = head.get("recorded", "")
    if isinstance(said, dict):
        return {"recorder": said}
    return {"recorded": str(said)}


def _unknown(
    content: object,
    known: Collection[str],
    place: str = "",
    noted: Collection[str] = (),
) -> list[Problem]:
    """Keys that nobody reads: each that looks like one that is not there, and
    the others together.

    Args:
        content: A map; of anything else nothing is told.
        known: Keys that are read.
        place: Where it stands, in words.
        noted: Keys that are not read, and are there on purpose.
    """
    if not isinstance(content, dict):
        return []
    where = f"{place}: " if place else ""
    absent = [key for key in known if key not in content]
    problems, others = [], []
    for key in content:
        if key in known or key in noted:
            continue
        word = str(key).lower()
        word = _MEANT.get(word, word)
        hint = suggest(word, absent)
        if hint:
            message = f"{where}no key {quoted(key)}{hint}"
            problems.append(warning(MANIFEST, message))
        else:
            others.append(quoted(key))
    if others:
        more = len(others) - _MOST_NAMES
        names = ", ".join(others[:_MOST_NAMES])
        names += f" and {more} more" if more > 0 else ""
        message = f"{where}no key {names}: ignored; allowed: {', '.join(known)}"
        problems.append(warning(MANIFEST, message))
    return problems


def _needed(device: Device) -> tuple[str, ...]:
    """What each run must say; of a diagram no torso that may be absent."""
    return tuple(n for n in _NEEDED if n != "contact" or not device.has_ports)


def _error_of(fault: Fault, place: str = "") -> Problem:
    """What a field must be, and what it is instead."""
    name, wanted, value = fault
    if value is None:
        message = f"{name} is missing: it must be {wanted}"
    else:
        message = f"{name} must be {wanted}, got {quoted(value)}"
    return error(MANIFEST, place + message)


def take_numbers(
    content: dict, section: str, device: Device
) -> tuple[dict[str, float], list[Fault]]:
    """The numbers of a section, "nominal" or "control", as a device declares
    them, and what is wrong with them.
    """
    declared = getattr(device, section)
    kind = NOT_NEGATIVE if device.may_be_none else POSITIVE
    values = content.get(section) or {}
    if not isinstance(values, dict):
        return {}, [Fault(section, "a mapping", values)]
    fields = {k: kind._replace(required=r) for k, r in declared.items()}
    taken, faults = take(values, fields)
    named = [fault._replace(name=f"{section}.{fault.name}") for fault in faults]
    return {name: float(value) for name, value in taken.items()}, named


def _neighbours(there: tuple[int, ...]) -> Field:
    """Declaration of the stages that were recorded, of those that are there."""
    return Field(
        f"neighbours of {', '.join(map(str, there))}, from the lowest up",
        lambda v: (
            isinstance(v, list)
            and v != []
            and all(type(i) is int for i in v)
            and v == [i for i in there if v[0] <= i <= v[-1]]
        ),
        required=False,
    )


def _parse_runs(
    items: list,
    settled_s: float,
    problems: list[Problem],
    needed: tuple[str, ...],
) -> tuple[Run, ...]:
    """The runs; their faults go to `problems`, usable values are kept."""
    runs = []
    for number, item in enumerate(items, start=1):
        values = {"file": "", "contact": True, "motion": "", "split": "fit"}
        taken, faults = {}, [Fault("it", "a mapping", item)]
        missing: list[str] = []
        if isinstance(item, dict):
            taken, faults = take(item, _RUN)
            missing = [key for key in needed if item.get(key) is None]
        if missing or faults:
            place = f"run {number}"
            if "file" in taken:
                place += f" ({quoted(taken['file'])[1:-1]})"
            if missing:
                message = f"{place} has no {', '.join(missing)}"
                problems.append(error(MANIFEST, message))
            problems += [_error_of(fault, f"{place}: ") for fault in faults]
        problems += _unknown(item, _RUN, f"run {number}", NOTES)
        values |= {"repeat_of": None, **taken}
        runs.append(Run(channels={}, settled_s=settled_s, **values))
    if runs:
        _check_runs(runs, problems)
    return tuple(runs)


def leaves_folder(file: str) -> bool:
    """Whether a run's path points outside its campaign's folder."""
    path = normpath(file.replace("\\", "/"))
    return isabs(path) or path.split("/")[0] in ("..", ".")


def chained_text(repeated: str) -> str:
    """What is wrong with a repeat of a repeat, after "repeat_of is"."""
    return (
        f"{quoted(repeated)}, itself a repeat; allowed: a run that repeats no"
        " other"
    )


def _check_runs(runs: list[Run], problems: list[Problem]) -> None:
    """What runs say of each other."""
    named: dict[str, list[int]] = {}
    for number, run in enumerate(runs, start=1):
        if run.file:
            named.setdefault(normpath(run.file), []).append(number)
    for path, (number, *others) in named.items():
        if leaves_folder(path):
            message = "the path leaves the campaign's folder"
            problems.append(error(runs[number - 1].file, message))
        if others:
            message = f"duplicate file: runs {number} and {others[0]} share it"
            message += f", and {len(others) - 1} more" if others[1:] else ""
            problems.append(error(runs[others[0] - 1].file, message))
    for number, run in enumerate(runs, start=1):
        if run.repeat_of is None:
            continue
        place = f"run {number} ({run.file}): repeat_of"
        if normpath(run.repeat_of) not in named:
            message = f"{place} names no run: {quoted(run.repeat_of)}"
            problems.append(error(MANIFEST, message))
        elif normpath(run.repeat_of) == normpath(run.file):
            problems.append(error(MANIFEST, f"{place} names the run itself"))
        elif runs[named[normpath(run.repeat_of)][0] - 1].repeat_of is not None:
            message = f"{place} is {chained_text(run.repeat_of)}"
            problems.append(error(MANIFEST, message))
    splits = {run.split for run in runs}
    if "fit" not in splits:
        message = "no run has split: fit, nothing to learn from"
        problems.append(error(MANIFEST, message))
    if "validation" not in splits:
        message = "no run has split: validation, no claim can be tested"
        problems.append(warning(MANIFEST, message))
