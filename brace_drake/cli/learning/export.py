"""The command `brace-drake export`: a campaign as one file for viewers."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from brace_drake.cli.options import AddCampaign, AddCommand
from brace_drake.core.places import check_replaced

_EPILOG = """\
example:
  brace-drake export recordings/monday --out monday.mcap

Each run becomes a topic of the MCAP file; Foxglove and other viewers plot its
channels. `brace-drake import monday.mcap` makes a campaign of it again.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `export`."""
    parser = AddCommand(
        subparsers,
        "export",
        Run,
        help="write a campaign as an MCAP file",
        description="Puts all runs of a campaign into one file.",
        epilog=_EPILOG,
    )
    AddCampaign(parser)
    parser.add_argument(
        "--out", required=True, metavar="FILE", help="file to make, *.mcap"
    )


def Run(args: argparse.Namespace) -> int:
    """Exports; prints how it comes back."""
    from brace_drake.recording import LoadCampaign
    from brace_drake.recording.importing.mcap_file import START, WriteMcap

    check_replaced(Path(args.out), ".mcap", START, "exported campaign")
    campaign = LoadCampaign(args.campaign)
    WriteMcap(campaign, args.out)
    print(f"written: {args.out}, {len(campaign.runs)} runs")
    print(f"back: brace-drake import {shlex.quote(args.out)} --out DIR")
    return 0
