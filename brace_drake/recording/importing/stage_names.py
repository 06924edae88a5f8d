"""Columns of a bench or brace, guessed from their names."""

from __future__ import annotations

import re
from collections.abc import Iterable

from brace_drake.recording.columns import BENCH, BRACE, DEVICES

# What a column is about, by words in its name; the first that is found counts.
_COMMAND = r"cmd|command(ed)?|drive|actuator|tau|u|stellkraft|antrieb"
_LENGTH = r"len|length|stroke|extension|pos|position|l|q|länge|laenge"
_TOLD = r"cmd|command(ed)?|stellkraft|antrieb"
_MARKER = r"(torso|marker|trunk|rumpf|thorax|mocap|vicon|optitrack)[xyz]?"
_VIRTUAL = r"virt(ual|uell)?|imp(edance|edanz)?|adm(ittance|ittanz)?"
_DESIRED = r"[yv]?(desired|des|ref|reference|target|setpoint|d|soll\w*)"
_AXIS = re.compile(r"\b(?:f|p|force|kraft|torso|marker|load|rumpf)?([xyz])\b")
_FEWEST_LEGS = 6


def guess_stage_channels(
    columns: Iterable[str],
) -> tuple[str, dict[str, str]] | None:
    """The device and its channels, where columns name six legs or more.

    Args:
        columns: Names of a file's columns.

    Returns:
        Device, and by column its channel; None where there are no such legs.
    """
    words = {column: _words(column) for column in columns}
    legs = {c: _leg_channel(w) for c, w in words.items()}
    lengths = {n for n in legs.values() if n and n.endswith("_length_m")}
    if len(lengths) < _FEWEST_LEGS:
        return None
    device = BENCH if len(lengths) == _FEWEST_LEGS else BRACE
    known = DEVICES[device].channels
    found = {c: c for c in words if c in known}
    for column, text in words.items():
        channel = legs[column] or _other_channel(text, device)
        is_new = column not in found and channel not in found.values()
        if channel in known and is_new:
            found[column] = channel
    return device, found


def words_of(column: str) -> str:
    """The words of a column's name, small, its unit in brackets left out."""
    name = re.sub(r"[\[(].*", "", column)
    return re.sub(r"(?<=[a-z])(?=[A-Z])|[_\-.]", " ", name).lower()


def _words(column: str) -> str:
    # A number is a word of its own, whatever it stands behind.
    return " ".join(re.sub(r"(\d+)", r" \1 ", words_of(column)).split())


def _has(words: str, pattern: str) -> bool:
    return re.search(rf"\b({pattern})\b", words) is not None


def _leg_channel(words: str) -> str | None:
    number = re.search(r"\b(\d+)\b", words)
    is_leg = _has(
        words,
        r"leg|bein|zylinder|cyl|cylinder|actuator|strut|l|len|length|u|q"
        rf"|{_TOLD}",
    )
    if number is None or not is_leg or _has(words, "ring|pad|torso"):
        return None
    k = int(number[1])
    if _has(words, _COMMAND) or _has(words, "force|kraft|f"):
        return f"leg{k}_force_command_N"
    if _has(words, rf"leg|bein|{_LENGTH}"):
        return f"leg{k}_length_m"
    return None


def _axis(words: str) -> str | None:
    found = _AXIS.search(words)
    return found[1] if found else None


def _other_channel(words: str, device: str) -> str | None:
    axis = _axis(words)
    if _has(words, _MARKER) and axis:
        return f"torso_{axis}_m"
    if _has(words, "t|time|timestamp|zeit|clock"):
        return "time_s"
    ring = re.search(r"\bring (\d)\b", words)
    i = ring[1] if ring else "2"
    if _has(words, _DESIRED):
        if _has(words, "ay|y?(acc|accel|acceleration)|a|soll(beschl\\w*)"):
            return f"ring{i}_ay_desired_m_s2"
        if _has(words, "vy|y?(vel|velocity|speed)|v|vref|soll(geschw\\w*)"):
            return f"ring{i}_vy_desired_m_s"
        return f"ring{i}_y_desired_m"
    if _has(words, _VIRTUAL):
        return f"ring{i}_y_virtual_m"
    if axis and _has(words, "(force|kraft|load|f)[xyz]?|ft"):
        return f"ring{i}_force_{axis}_N"
    return None
