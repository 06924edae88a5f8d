"""The command `brace-drake devices`: what can be recorded and diagnosed."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Iterable
from typing import Any

from brace_drake.cli.library.table import format_table
from brace_drake.cli.options import AddCommand, AddJson, PrintJson
from brace_drake.recording.columns import MARKS

_EPILOG = """\
example:
  brace-drake devices

One line for each device that campaign.yaml can name: where its nominal numbers
are from, and its channels, those in brackets optional; leg1..6 stands for six
legs, x..z for three axes. Devices of installed packages are among them.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `devices`."""
    parser = AddCommand(
        subparsers,
        "devices",
        Run,
        help="list the devices that can be diagnosed, with their channels",
        description="Lists the devices and what each records.",
        epilog=_EPILOG,
    )
    AddJson(parser)


def Run(args: argparse.Namespace) -> int:
    """Prints the devices."""
    devices = describe_devices()
    if args.json:
        PrintJson({"devices": devices})
        return 0
    rows = []
    for device in devices:
        needed, other = (
            shorten_names(
                c["channel"] for c in device["channels"] if c["optional"] is is_
            )
            for is_ in (False, True)
        )
        names = " ".join([*needed, *(f"[{name}]" for name in other)])
        if device["channels_from_campaign"]:
            names = f"{names} and those of its section diagram"
        rows.append((device["device"], device["scenario"], names))
    print(format_table(("device", "nominal scenario", "channels"), rows))
    return 0


def describe_devices() -> list[dict]:
    """The devices in plain types."""
    from brace_drake.devices.device import DEVICES as DIAGNOSED
    from brace_drake.recording.columns import DEVICES

    return [
        {
            "device": name,
            "diagnosed": name in DIAGNOSED,
            "scenario": _scenario_of(name, recorded),
            "nominal": _numbers(recorded.nominal),
            "control": _numbers(recorded.control),
            "channels": [
                {
                    "channel": c.name,
                    "unit": c.unit,
                    "least": c.low,
                    "most": c.high,
                    "optional": c.is_optional or not c.required,
                }
                for c in recorded.channels.values()
            ],
            "channels_from_campaign": recorded.has_ports,
        }
        for name, recorded in DEVICES.items()
    ]


def _numbers(declared: dict[str, bool]) -> list[dict]:
    return [{"name": n, "required": r} for n, r in declared.items()]


def _scenario_of(name: str, recorded: Any) -> str:
    """Where the nominal numbers of a device are from."""
    from brace_drake.scenario.load import SCHEMAS

    if recorded.has_ports:
        return "function of --diagram"
    if recorded.nominal:
        return "numbers of campaign.yaml"
    schema = SCHEMAS.get(name)
    if schema is None or not dataclasses.is_dataclass(schema):
        return "its package's"
    return f"the package's, or --scenario with device: {name}"


def shorten_names(names: Iterable[str]) -> list[str]:
    """Names that differ in one number or axis as one: leg1..6_length_m."""
    found = list(names)
    while True:
        shorter = _merged(found)
        if len(shorter) == len(found):
            return shorter
        found = shorter


def _merged(names: list[str]) -> list[str]:
    """Names with the first part merged that makes the most of them one."""
    groups: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for name in names:
        for part in MARKS.finditer(name):
            key = name[: part.start()], name[part.end() :]
            groups.setdefault(key, []).append((part.group(), name))
    key, group = max(
        groups.items(), key=lambda item: len(item[1]), default=(None, [])
    )
    parts = [part for part, _ in group]
    if key is None or len(parts) < 2 or not _in_row(parts):
        return names
    merged = f"{key[0]}{parts[0]}..{parts[-1]}{key[1]}"
    members = {name for _, name in group}
    first = next(name for name in names if name in members)
    return [
        merged if name == first else name
        for name in names
        if name == first or name not in members
    ]


def _in_row(parts: list[str]) -> bool:
    """Whether numbers, or axes, follow each other."""
    if all(part.isdigit() for part in parts):
        numbers = [int(part) for part in parts]
        return numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    return "".join(parts) in "xyz"
