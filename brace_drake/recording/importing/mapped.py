"""A campaign from files and a map that says which column is which channel."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError, quoted, suggest
from brace_drake.core.places import real_path
from brace_drake.core.reading import LoadYaml, ReadBytes, in_file
from brace_drake.recording.columns import DEVICES, Device
from brace_drake.recording.fields import (
    DURATION,
    RATE,
    RECORDED,
    SUBJECT,
    SWITCH,
    TEXT,
    WHAT_FOR,
    Field,
)
from brace_drake.recording.importing.derived import derivable, derive
from brace_drake.recording.importing.expand import expand_rules
from brace_drake.recording.importing.gaps import (
    REFUSE,
    SPLIT,
    without_gaps,
)
from brace_drake.recording.importing.rules import (
    parse_rule,
    read_channels,
    resample,
    take_map,
)
from brace_drake.recording.importing.tables import OPTIONS, LoadTable
from brace_drake.recording.manifest import (
    chained_text,
    leaves_folder,
    take_numbers,
)
from brace_drake.recording.ports import Ports, parse_ports
from brace_drake.recording.recording import Campaign, Run, ScenarioFile
from brace_drake.recording.table import Columns

FORMAT = "brace-import/1"
_MOST_MB = 4

_HEAD = {
    "format": Field(repr(FORMAT), lambda v: v == FORMAT),
    "device": Field(
        ", ".join(DEVICES), lambda v: isinstance(v, str) and v in DEVICES
    ),
    "columns": Field("a map of channels", lambda v: isinstance(v, dict)),
    "runs": Field("a list of runs", lambda v: isinstance(v, list) and v != []),
    "options": Field(
        "a map of names", lambda v: isinstance(v, dict), required=False
    ),
    "rate_hz": RATE._replace(required=False),
    "settled_s": DURATION,
    "gaps": Field(
        f"{SPLIT} or {REFUSE}", lambda v: v in (SPLIT, REFUSE), required=False
    ),
    **dict.fromkeys(
        ("nominal", "control"),
        Field("a map of numbers", lambda v: isinstance(v, dict), False),
    ),
    "diagram": Field(
        "a map with outputs", lambda v: isinstance(v, dict), required=False
    ),
    "scenario": TEXT,
    "recorded": RECORDED,
    "subject": SUBJECT,
}
_RUN = {
    "file": TEXT._replace(required=True),
    "contact": SWITCH,
    **dict.fromkeys(("motion", "repeat_of", "name"), TEXT),
    "split": WHAT_FOR,
}


def ImportCampaign(path: str | Path) -> Campaign:
    """Reads a map and all files that it names.

    The map is YAML: `format: brace-import/1`, `device`, `subject`, `columns`
    (channel: name of the file's column, or {from, unit, scale, offset}, or
    {constant}; `from` may be a map of columns to the factors by which they are
    added up, and names may have braces, see `expand`),
    `runs` (items of campaign.yaml, with the foreign `file`),
    `options` for the reader, `rate_hz` where the files are to be resampled,
    `gaps: split` where a file with gaps in time is to be several runs,
    `nominal`, `control` and `diagram` as campaign.yaml has them, `scenario`,
    a file in the map's folder that is copied into the campaign, and
    `settled_s`, how long the first reference had been held before each run.

    Desired velocities and accelerations that it does not name are derivatives
    of the desired motion.

    Raises:
        CampaignError: One line: file, key or column, and what is allowed.
    """
    path = Path(path)
    head = take_map(LoadYaml(path, CampaignError), _HEAD, f"{path}: ")
    scenario = _scenario(path, head)
    device = DEVICES[head["device"]]
    channels = device.channels
    given = expand_rules(f"{path}: columns.", head["columns"])
    rules = {n: parse_rule(path, n, rule) for n, rule in given.items()}
    for name in rules:
        if not device.has_channel(name):
            hint = suggest(name, channels)
            raise CampaignError(f"{path}: no channel {quoted(name)}{hint}")
    ports = _ports(path, head, device)
    needed = [n for n, c in channels.items() if c.required]
    needed += ports.columns if ports is not None else ()
    rates = derivable(channels, rules)
    missing = [n for n in needed if n not in rules and n not in rates]
    if missing:
        raise CampaignError(f"{path}: columns has no {', '.join(missing)}")
    options = take_map(head.get("options", {}), OPTIONS, f"{path}: options.")
    items = [
        take_map(item, _RUN, f"{path}: run {number}: ")
        for number, item in enumerate(head["runs"], 1)
    ]
    _name_runs(path, items)
    rate = head.get("rate_hz")
    settled = float(head.get("settled_s", 0.0))
    numbers = _numbers(path, head, device)
    gaps = head.get("gaps", REFUSE)
    runs = []
    for item in items:
        source = path.parent / item["file"]
        columns = read_channels(source, rules, LoadTable(source, options))
        parts = without_gaps(source, columns, gaps, rate)
        for number, part in enumerate(parts, 1):
            if rate is not None:
                part = resample(source, part, float(rate))
            part = derive(part, rates)
            name = item["name"] + f"_{number}" * (len(parts) > 1)
            runs.append(_make_run({**item, "name": name}, part, settled))
    _check_files(path, runs)
    _check_repeats(path, runs)
    # Differences of times have no more digits than that.
    found = f"{1.0 / np.median(np.diff(runs[0].time_s)):.9g}"
    return Campaign(
        path,
        head["device"],
        float(rate or found),
        str(head.get("subject") or ""),
        tuple(runs),
        ports=ports,
        scenario=scenario,
        recorded=str(head.get("recorded", "")),
        **numbers,
    )


def _scenario(path: Path, head: dict) -> ScenarioFile | None:
    """The scenario that the map names, which goes with the campaign."""
    name = head.get("scenario")
    if name is None:
        return None
    folder = path.parent
    is_within = real_path(folder / name).is_relative_to(real_path(folder))
    if leaves_folder(name) or not is_within:
        raise CampaignError(
            f"{path}: scenario is {quoted(name)}; allowed: a path relative to"
            " the map's folder, of a file within it"
        )
    with in_file(f"{path}: scenario: {name}", CampaignError):
        return ScenarioFile(name, ReadBytes(folder / name, _MOST_MB))


def _ports(path: Path, head: dict, device: Device) -> Ports | None:
    """The section `diagram` of the map, where its device has such."""
    if not device.has_ports:
        return None
    ports, faults = parse_ports(head.get("diagram"))
    if faults:
        name, wanted, value = faults[0]
        raise CampaignError(
            f"{path}: {name} is {quoted(value)}; allowed: {wanted}"
        )
    return ports


def _numbers(path: Path, head: dict, device: Device) -> dict:
    """`nominal` and `control` of the map, where it has them."""
    found = {}
    for section in ("nominal", "control"):
        if section not in head:
            continue
        for name in head[section]:
            known = getattr(device, section)
            if name not in known:
                allowed = f"; allowed: {', '.join(known) or 'none'}"
                hint = suggest(name, known) or allowed
                raise CampaignError(f"{path}: {section}: no {name!r}{hint}")
        found[section], faults = take_numbers(head, section, device)
        for name, wanted, value in faults:
            raise CampaignError(
                f"{path}: {name} is {quoted(value)}; allowed: {wanted}"
            )
    return found


def _check_files(path: Path, runs: list[Run]) -> None:
    """No two runs, or parts of them, are written to one file."""
    seen: dict[str, str] = {}
    for run in runs:
        file = os.path.normpath(run.file).lower()
        if file in seen:
            raise CampaignError(
                f"{path}: two runs would be {quoted(run.file)}; give them"
                " names of their own by `name`"
            )
        seen[file] = run.file


def _check_repeats(path: Path, runs: list[Run]) -> None:
    """A run that was split repeats none, and none repeats it."""
    files = {run.file for run in runs}
    for run in runs:
        if run.repeat_of is not None and run.repeat_of not in files:
            raise CampaignError(
                f"{path}: {run.file} repeats {run.repeat_of}, which has gaps"
                " and was split"
            )


def _name_runs(path: Path, items: list[dict]) -> None:
    """Gives each run its name; `repeat_of` may be that, or a foreign file.

    Raises:
        CampaignError: Runs share a name, or a repeat repeats no run.
    """
    files: dict[str, str] = {}
    for number, item in enumerate(items, 1):
        name = item.setdefault("name", Path(item["file"]).stem)
        if name in files:
            raise CampaignError(
                f"{path}: run {number}: {quoted(name)} is another run's name"
                " already; give it one of its own by `name`"
            )
        files[name] = f"{name}.csv"
    for item in items:
        files.setdefault(item["file"], f"{item['name']}.csv")
        files.setdefault(f"{item['name']}.csv", f"{item['name']}.csv")
    for number, item in enumerate(items, 1):
        repeated = item.get("repeat_of")
        if repeated is None:
            continue
        if files.get(repeated, f"{item['name']}.csv") == f"{item['name']}.csv":
            raise CampaignError(
                f"{path}: run {number}: repeat_of is {quoted(repeated)};"
                f" allowed: another run{suggest(repeated, files)}"
            )
        item["repeat_of"] = files[repeated]
    repeats = {f"{i['name']}.csv" for i in items if i.get("repeat_of")}
    for number, item in enumerate(items, 1):
        if item.get("repeat_of") in repeats:
            raise CampaignError(
                f"{path}: run {number}: repeat_of is"
                f" {chained_text(item['repeat_of'])}"
            )


def _make_run(item: dict, channels: Columns, settled_s: float) -> Run:
    name = item["name"]
    return Run(
        file=f"{name}.csv",
        contact=item.get("contact", True),
        motion=item.get("motion", name),
        repeat_of=item.get("repeat_of"),
        split=item.get("split", "fit"),
        channels=channels,
        settled_s=settled_s,
    )
