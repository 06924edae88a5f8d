"""The runs that a campaign.yaml names, entry by entry."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass

from brace_drake.recording.findings import error, quoted, warning
from brace_drake.recording.recording import Problem

MANIFEST = "campaign.yaml"
SPLITS = ("fit", "validation")
_REQUIRED_KEYS = ("file", "contact", "motion", "split")


@dataclass(frozen=True)
class RunEntry:
    """One item of `runs`; a value that was unusable is its default."""

    file: str | None = None
    contact: bool = True
    motion: str = ""
    repeat_of: str | None = None
    split: str = "fit"


def manifest_error(message: str) -> Problem:
    """An error of campaign.yaml itself."""
    return error(MANIFEST, message)


def wanted_text(name: str, wanted: str, value: object) -> str:
    """What a key must be, and what it is instead."""
    if value is None:
        return f"{name} is missing: it must be {wanted}"
    return f"{name} must be {wanted}, got {quoted(value)}"


def parse_runs(content: dict, problems: list[Problem]) -> tuple[RunEntry, ...]:
    """The entries of `runs`; their faults go to `problems`."""
    runs = content.get("runs")
    if not isinstance(runs, list) or not runs:
        found = None if runs == [] else runs
        problems.append(
            manifest_error(wanted_text("runs", "a list of runs", found))
        )
        return ()
    entries = tuple(
        _parse_run(run, number, problems)
        for number, run in enumerate(runs, start=1)
    )
    _check_files(entries, problems)
    _check_repeats(entries, problems)
    _check_splits(entries, problems)
    return entries


def _parse_run(run: object, number: int, problems: list[Problem]) -> RunEntry:
    """One entry; its faults go to `problems`, usable values are kept."""
    if not isinstance(run, dict):
        problems.append(
            manifest_error(wanted_text(f"run {number}", "a mapping", run))
        )
        return RunEntry()
    place = f"run {number}"
    if isinstance(run.get("file"), str):
        place += f" ({quoted(run['file'])[1:-1]})"
    missing = [key for key in _REQUIRED_KEYS if run.get(key) is None]
    if missing:
        problems.append(manifest_error(f"{place} has no {', '.join(missing)}"))
    kinds = {"file": str, "contact": bool, "motion": str, "repeat_of": str}
    names = {str: "text", bool: "true or false"}
    values = {}
    for key, kind in kinds.items():
        value = run.get(key)
        if isinstance(value, kind) and value != "":
            values[key] = value
        elif value is not None:
            wanted = wanted_text(key, names[kind], value)
            problems.append(manifest_error(f"{place}: {wanted}"))
    split = run.get("split")
    if split in SPLITS:
        values["split"] = split
    elif split is not None:
        wanted = wanted_text("split", " or ".join(SPLITS), split)
        problems.append(manifest_error(f"{place}: {wanted}"))
    return RunEntry(**values)


def leaves_folder(file: str) -> bool:
    """Whether a run's path points outside its campaign's folder."""
    path = posixpath.normpath(file.replace("\\", "/"))
    return posixpath.isabs(path) or path.split("/")[0] in ("..", ".")


def same_file(one: str, other: str) -> bool:
    """Whether two run paths mean the same file."""
    return posixpath.normpath(one) == posixpath.normpath(other)


def _check_files(
    entries: tuple[RunEntry, ...], problems: list[Problem]
) -> None:
    seen: dict[str, int] = {}
    for number, entry in enumerate(entries, start=1):
        if entry.file is None:
            continue
        if leaves_folder(entry.file):
            problems.append(
                error(entry.file, "the path leaves the campaign's folder")
            )
        first = seen.setdefault(posixpath.normpath(entry.file), number)
        if first != number:
            message = f"duplicate file: runs {first} and {number} share it"
            problems.append(error(entry.file, message))


def _check_repeats(
    entries: tuple[RunEntry, ...], problems: list[Problem]
) -> None:
    files = [entry.file for entry in entries if entry.file is not None]
    for number, entry in enumerate(entries, start=1):
        if entry.repeat_of is None:
            continue
        place = f"run {number} ({entry.file}): repeat_of"
        if not any(same_file(entry.repeat_of, file) for file in files):
            problems.append(
                manifest_error(
                    f"{place} names no run: {quoted(entry.repeat_of)}"
                )
            )
        elif entry.file and same_file(entry.repeat_of, entry.file):
            problems.append(manifest_error(f"{place} names the run itself"))


def _check_splits(
    entries: tuple[RunEntry, ...], problems: list[Problem]
) -> None:
    splits = {entry.split for entry in entries}
    if "fit" not in splits:
        problems.append(
            manifest_error("no run has split: fit, nothing to learn from")
        )
    if "validation" not in splits:
        problems.append(
            warning(
                MANIFEST,
                "no run has split: validation, no claim can be tested",
            )
        )
