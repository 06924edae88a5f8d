"""The command `brace-drake import`: a campaign from a lab's own files."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from brace_drake.cli.options import AddCommand
from brace_drake.recording.recording import Campaign

_EPILOG = """\
example:
  brace-drake import --init monday.csv --plot monday.png > monday.map.yaml
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

Names may have braces, `leg{1..6}_length_m: {from: "L{} (mm)", unit: mm}`, and
`from` may add columns up, `{from: {left: 0.5, right: 0.5}}`. Without a row of
names columns are "1", "2" and so on. Desired rates that are left out are
derivatives of the desired motion.

Files: text (CSV, tabs, blanks), MATLAB, NI TDMS, Excel, JSON, numpy, HDF5,
MCAP, bags of ROS 1 and 2; `options: {group: NAME}` is a struct, sheet or topic.
`rate_hz` resamples; `gaps: split` makes a run of each part of a file with gaps
in time; `nominal` and `control` go to campaign.yaml. What `brace-drake export`
has written (*.mcap) needs no map.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `import`."""
    parser = AddCommand(
        subparsers,
        "import",
        Run,
        help="make a campaign from the files of other programs",
        description="Turns a lab's own recordings into a campaign.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "map", metavar="MAP", help="*.yaml, see the example; or *.mcap"
    )
    parser.add_argument(
        "--plot", metavar="PNG", help="with --init: draw the columns too"
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
        return _init(args)
    from brace_drake.recording import WriteCampaign
    from brace_drake.recording.importing.mapped import ImportCampaign
    from brace_drake.recording.importing.mcap_file import LoadMcapCampaign
    from brace_drake.recording.write import check_new_folder

    check_new_folder(Path(args.out))
    from_map = not args.map.endswith(".mcap")
    campaign = (ImportCampaign if from_map else LoadMcapCampaign)(args.map)
    _check(campaign)
    WriteCampaign(campaign, args.out)
    print(f"campaign: {args.out}, {len(campaign.runs)} runs")
    print(f"next: brace-drake check {args.out}")
    return 0


def _check(campaign: Campaign) -> None:
    """Runs have as many rows as they need, and the scenario is one.

    Raises:
        CampaignError: One line: file, run, rows, what is allowed.
        ScenarioError: One line: file, key path, value, what is allowed.
    """
    from brace_drake.recording.importing.rules import check_rows

    for run in campaign.runs:
        check_rows(f"{campaign.path}: {run.file}", len(run.time_s))
    if campaign.scenario is not None:
        from brace_drake.devices.nominal_scenario import choose_scenario

        is_within = campaign.path.suffix == ".mcap"
        place = campaign.path if is_within else campaign.path.parent
        choose_scenario(replace(campaign, path=place))


def _init(args: argparse.Namespace) -> int:
    """Prints a draft of a map, and draws what it was made from."""
    from brace_drake.recording.importing.draft import draft_map, read_draft

    if args.plot is not None:
        from brace_drake.core.places import check_replaced

        check_replaced(Path(args.plot), ".png", b"\x89PNG\r\n", "picture")
    draft = read_draft(args.map)
    print(draft_map(draft), end="")
    if args.plot is not None:
        from brace_drake.core.output import WriteBytes
        from brace_drake.recording.importing.draft_plot import plot_draft

        WriteBytes(Path(args.plot), plot_draft(draft))
    return 0
