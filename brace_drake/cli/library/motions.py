"""The command `brace-drake motions`: the library of motions."""

from __future__ import annotations

import argparse

from brace_drake.cli.library.table import format_table
from brace_drake.cli.options import AddCommand, AddJson, PrintJson

_EPILOG = """\
example:
  brace-drake motions

One line for each motion that --motion and --motions take: its name, how long it
lasts, whether the torso is there, and what it does. Those with a star are what
a common campaign holds.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `motions`."""
    parser = AddCommand(
        subparsers,
        "motions",
        Run,
        help="list the motions that a device can be asked for",
        description="Lists the library of motions of bench and brace.",
        epilog=_EPILOG,
    )
    AddJson(parser)


def Run(args: argparse.Namespace) -> int:
    """Prints the motions."""
    motions = describe_motions()
    if args.json:
        PrintJson({"motions": motions})
        return 0
    rows = [
        (
            m["motion"] + " *" * m["is_standard"],
            f"{m['duration_s']:g} s",
            "with torso" if m["contact"] else "free",
            m["title"],
        )
        for m in motions
    ]
    print(format_table(("motion", "lasts", "torso", "title"), rows))
    return 0


def describe_motions() -> list[dict]:
    """The motions in plain types."""
    from brace_drake.devices.motions.library import (
        MOTIONS,
        STANDARD,
        MakeMotion,
    )

    rows = []
    for name in MOTIONS:
        motion = MakeMotion(name)
        y = motion.samples
        step = float(motion.time[1] - motion.time[0])
        rows.append(
            {
                "motion": name,
                "title": motion.meaning,
                "kind": motion.kind,
                "contact": motion.contact,
                "duration_s": len(motion.time) * step,
                "is_standard": name in STANDARD,
                "largest_y_m": float(abs(y[:, 0]).max()),
                "largest_speed_m_s": float(abs(y[:, 1]).max()),
            }
        )
    return rows
