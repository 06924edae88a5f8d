"""The command `brace-drake import`: a campaign from a lab's own files."""

from __future__ import annotations

import argparse

from brace_drake.cli.options import AddCommand

_EPILOG = """\
example:
  brace-drake import --init monday.csv > monday.map.yaml
  brace-drake import monday.map.yaml --out recordings/monday

where monday.map.yaml says which column is which channel:
  format: brace-import/1
  device: pad bench
  subject: phantom 2
  columns:
    time_s: Time
    displacement_m: {from: "Travel (mm)", unit: mm}
    force_N: {from: Load, offset: -0.2}
  options: {delimiter: ";", decimal: ","}
  runs:
  - {file: first.csv, motion: push, split: fit}
  - {file: second.tdms, motion: push, split: validation}

Files: CSV, MATLAB up to -v7 (*.mat), NI TDMS, JSON messages of MCAP (options:
{group: TOPIC}). `rate_hz` resamples. `gaps: split` makes a run of each part
between gaps in time. `nominal` and `control` go to campaign.yaml.
A file that `brace-drake export` has written (*.mcap) needs no map.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `import`."""
    parser = AddCommand(
        subparsers,
        "import",
        Run,
        help="make a campaign from CSV, MATLAB, TDMS or MCAP files",
        description="Turns a lab's own recordings into a campaign.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "map", metavar="MAP", help="*.yaml, see the example; or *.mcap"
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--out", metavar="DIR", help="campaign folder to make")
    what.add_argument(
        "--init",
        action="store_true",
        help="MAP is a recording: print a draft of a map for it",
    )


def Run(args: argparse.Namespace) -> int:
    """Imports and writes; prints what to do next."""
    if args.init:
        from brace_drake.recording.importing.draft import draft_map

        print(draft_map(args.map), end="")
        return 0
    from brace_drake.recording import WriteCampaign
    from brace_drake.recording.importing.mapped import ImportCampaign
    from brace_drake.recording.importing.mcap_file import LoadMcapCampaign

    from_map = not args.map.endswith(".mcap")
    campaign = (ImportCampaign if from_map else LoadMcapCampaign)(args.map)
    WriteCampaign(campaign, args.out)
    print(f"campaign: {args.out}, {len(campaign.runs)} runs")
    print(f"next: brace-drake check {args.out}")
    return 0
