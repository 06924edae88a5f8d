"""The command `brace-drake doctor`: what is missing, what is assumed."""

from __future__ import annotations

import argparse
import ctypes.util
import glob
import importlib.metadata
import os
import platform
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from brace_drake.cli.options import AddCommand, AddJson, PrintJson
from brace_drake.core.resources import wanted_cache_path

_EPILOG = """\
example:
  brace-drake doctor
  brace-drake doctor --json
  brace-drake doctor diagrams/bench.scenario.yaml

With a scenario or a campaign it also lists the tolerance of each number, and
whether the tolerance is stated or assumed.

Ends with status 2 if something needed is missing, else with 0.
"""
_OK, _OPTIONAL, _MISSING = "ok", "optional", "missing"
_LEAST_MEMORY, _LEAST_DISK = 4.0, 2.0  # GB that a diagnosis wants.
# What each extra is for.
_EXTRAS = {
    "lab": "files of a lab [lab]",
    "mcap": "MCAP files [mcap]",
    "train": "training [train]",
    "onnx": "networks as ONNX [onnx]",
    "pandas": "tables as DataFrames [pandas]",
    "cluster": "work on several machines [cluster]",
    "notebooks": "notebooks run by tests [notebooks]",
    "docs": "building the documentation [docs]",
    "dev": "developers alone [dev]",
}


class Finding(NamedTuple):
    """One thing that was looked at, and what to do about it."""

    what: str
    status: str  # ok, missing, or optional: missing, and not needed by most
    text: str


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `doctor`."""
    parser = AddCommand(
        subparsers,
        "doctor",
        Run,
        help="say what is missing on this machine",
        description="Looks at Python, packages, programs, ports and folders.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "of",
        nargs="?",
        metavar="SCENARIO|CAMPAIGN",
        help="tell its tolerances too: a scenario's file, or a campaign's"
        " folder, whose device has the package's own",
    )
    AddJson(parser)


def Run(args: argparse.Namespace) -> int:
    """Prints a line for each thing; 2 when one that is needed is missing."""
    found = examine_machine()
    if args.of is not None:
        found += examine_tolerances(args.of)
    if args.json:
        PrintJson({f.what: {"status": f.status, "text": f.text} for f in found})
    else:
        width = max(len(f.what) for f in found)
        for f in found:
            print(f"{f.status:8}  {f.what:{width}}  {f.text}")
    return 2 if any(f.status == _MISSING for f in found) else 0


def examine_machine() -> list[Finding]:
    """All findings, in the order of what a newcomer meets."""
    package = importlib.metadata.metadata("brace_drake")
    return [
        Finding("brace_drake", _OK, package["Version"]),
        _python(package["Requires-Python"]),
        *_packages(importlib.metadata.requires("brace_drake") or []),
        _program("dot", "apt-get install graphviz, to draw diagrams"),
        _program("chromium", "to look at reports; any browser does"),
        _serial_ports(sorted(glob.glob("/dev/tty[AU][CS][MB]*"))),
        _law_cache(),
        Finding("cores", _OK, f"{os.cpu_count() or 1}"),
        _memory(),
        _amount("disk", shutil.disk_usage(".").free, _LEAST_DISK),
    ]


def examine_tolerances(path: str) -> list[Finding]:
    """How exactly the numbers of a scenario, or of a campaign's, are known.

    Raises:
        BraceError: Neither is there.
    """
    from dataclasses import fields

    from brace_drake.devices.nominal_scenario import choose_scenario
    from brace_drake.recording import LoadCampaign
    from brace_drake.scenario.load import SCHEMAS, LoadScenario

    if Path(path).is_dir():
        campaign = LoadCampaign(path)
        named, device = choose_scenario(campaign), campaign.device
        scenario = named.scenario or SCHEMAS[device]()
        place = named.file or f"the package's {device}"
    else:
        scenario, place = LoadScenario(path), path
    own = getattr(scenario, "tolerances", None)
    if own is None:
        text = f"none: the numbers of a {scenario.device} are fitted"
        return [Finding("tolerances", _OK, text)]
    if own.is_stated:
        text = f"stated in {place}, the defaults for what it leaves out"
        if own.named >= {f.name for f in fields(own)}:
            text = f"stated in {place}"
        found = [Finding("tolerances", _OK, text)]
    else:
        text = f"assumed, as {place} states none"
        found = [Finding("tolerances", _OPTIONAL, text)]
    for f in fields(own):
        value, unit = getattr(own, f.name), f.metadata["limits"].unit
        text = f"{value:g} {unit}".rstrip() if value > 0.0 else "exact"
        text += "" if f.name in own.named else ", the default"
        found.append(Finding(f"tolerances.{f.name}", _OK, text))
    return found


def _python(allowed: str) -> Finding:
    text = f"{platform.python_version()}, {platform.machine()}"
    if SpecifierSet(allowed).contains(platform.python_version()):
        return Finding("python", _OK, text)
    return Finding("python", _MISSING, f"{text}; allowed: {allowed}")


def _packages(requirements: list[str]) -> Iterator[Finding]:
    """What the package requires, extras after what is always needed."""
    found: dict[str, Requirement] = {}
    # Developers ask for all that other extras ask for.
    for wanted in sorted(
        map(Requirement, requirements), key=lambda w: _extra(w) == "dev"
    ):
        found.setdefault(wanted.name, wanted)
    found.pop("brace_drake", None)
    yield from map(_package, found.values())
    if platform.system() == "Linux":
        there = ctypes.util.find_library("glib-2.0") is not None
        hint = "there" if there else "apt-get install libglib2.0-0"
        yield Finding("libglib-2.0", _OK if there else _MISSING, hint)


def _package(wanted: Requirement) -> Finding:
    """Whether a package is there, in a version that is allowed."""
    needed = wanted.marker is None or wanted.marker.evaluate({"extra": ""})
    status = _MISSING if needed else _OPTIONAL
    hint = f"pip install '{wanted.name}{wanted.specifier}'"
    use = ""
    if not needed:
        use = f", for {_EXTRAS.get(_extra(wanted), 'an extra')}"
        hint += use
    try:
        found = importlib.metadata.version(wanted.name)
    except importlib.metadata.PackageNotFoundError:
        return Finding(wanted.name, status, hint)
    if wanted.specifier.contains(found, prereleases=True):
        return Finding(wanted.name, _OK, found + use)
    return Finding(wanted.name, status, f"{found} is another; {hint}")


def _extra(wanted: Requirement) -> str:
    """The first extra that asks for a package."""
    found = re.search(r'extra == "([^"]+)"', str(wanted.marker))
    return found.group(1) if found else ""


def _program(name: str, what_for: str) -> Finding:
    path = shutil.which(name)
    if path:
        return Finding(name, _OK, path)
    return Finding(name, _OPTIONAL, f"not on the path: {what_for}")


def _serial_ports(ports: list[str]) -> Finding:
    if not ports:
        return Finding(
            "serial", _OPTIONAL, "no port; brace-drake emulate makes one"
        )
    closed = [p for p in ports if not os.access(p, os.R_OK | os.W_OK)]
    if closed:
        text = f"{', '.join(closed)}: no permission; join the group dialout"
        return Finding("serial", _OPTIONAL, text)
    return Finding("serial", _OK, ", ".join(ports))


def _law_cache() -> Finding:
    """Where compiled laws are kept; without it a temporary place is taken."""
    base = folder = Path(
        os.environ.get("NUMBA_CACHE_DIR") or wanted_cache_path()
    )
    while not folder.exists():
        folder = folder.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            return Finding("compiled laws", _OK, f"kept in {base}")
    except OSError as error:
        text = f"{folder}: {error.strerror}; set XDG_CACHE_HOME elsewhere"
        return Finding("compiled laws", _MISSING, text)


def _memory() -> Finding:
    try:
        size = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (ValueError, OSError, AttributeError):
        return Finding("memory", _OPTIONAL, "not known on this system")
    return _amount("memory", size, _LEAST_MEMORY)


def _amount(what: str, size: int, least: float) -> Finding:
    gigabytes = size / 2**30
    if gigabytes >= least:
        return Finding(what, _OK, f"{gigabytes:.1f} GB")
    text = f"{gigabytes:.1f} GB; a diagnosis wants {least:g}"
    return Finding(what, _OPTIONAL, text)
