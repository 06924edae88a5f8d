"""The command `brace-drake trend`: one machine or subject over dates."""

from __future__ import annotations

import argparse
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from brace_drake.cli.diagnosis.diagnose import folder_names
from brace_drake.cli.options import (
    AddCommand,
    AddDiagram,
    AddJobs,
    AddJson,
    AddScenario,
    PrintJson,
    find_diagram_option,
    name_scenario_option,
    open_workers_option,
)
from brace_drake.core.output import HoldFolder, MakeFolder, WriteJson
from brace_drake.core.progress import share_bar

_EPILOG = """\
examples:
  brace-drake trend results/january results/march results/may --out trend
  brace-drake trend campaigns/january campaigns/march --out trend \\
      --dates 2026-01-12,2026-03-09

Folders hold a diagnosis.json, or are campaigns, which are diagnosed first; what
comes out is kept, so that a second call is quick. The date of a campaign is
`recorded: 2026-01-12` in its campaign.yaml; without dates the order counts.
Writes trend.json, trend.csv and trend.html. Where nothing changes, a page
raises an alarm with the probability --level at most.
"""
# No interval is known so far into its tails.
_LEAST_LEVEL = 1e-9


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `trend`."""
    parser = AddCommand(
        subparsers,
        "trend",
        Run,
        help="follow parameters, gap and verdict over several sessions",
        description="Tests whether a machine or subject changes over sessions.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "folders",
        nargs="+",
        metavar="FOLDER",
        help="diagnosis (diagnosis.json) or campaign (campaign.yaml)",
    )
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="folder for the results"
    )
    parser.add_argument(
        "--dates",
        metavar="A,B,C",
        help="dates of the recordings, one for each folder in its order"
        " (default: those of the campaigns, else the order)",
    )
    parser.add_argument(
        "--split",
        action="store_true",
        help="a trend of each device, subject and scenario, in folders of DIR"
        " (default: several are refused)",
    )
    parser.add_argument(
        "--level",
        type=_share,
        default=0.01,
        metavar="P",
        help="probability of any alarm where nothing changes (default: 0.01)",
    )
    parser.add_argument(
        "--repeatability",
        type=_share_or_none,
        default=0.0,
        metavar="SHARE",
        help="known scatter between sessions without a change, as a share of"
        " each parameter, one standard deviation (default: 0, it is estimated)",
    )
    parser.add_argument(
        "--html",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="write the page trend.html (default: yes)",
    )
    AddScenario(parser)
    AddDiagram(parser)
    AddJobs(parser)
    AddJson(parser)


def _share(text: str) -> float:
    value = _share_or_none(text)
    if value < _LEAST_LEVEL:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number from {_LEAST_LEVEL:g} to below 1"
        )
    return value


def _share_or_none(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value < 1.0:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number from 0 to below 1"
        )
    return value


def Run(args: argparse.Namespace) -> int:
    """Reads or diagnoses, tests, writes; prints the trend and the files."""
    from brace_drake.trend.document import MakeTrendDocument
    from brace_drake.trend.grouping import (
        check_alike,
        make_timeline,
        parse_dates,
        split_sessions,
    )
    from brace_drake.trend.page import WriteTrend, trend_files
    from brace_drake.trend.table import format_text

    out = HoldFolder(Path(args.out))
    dates = parse_dates(args.dates, len(args.folders)) if args.dates else None
    sessions = _sessions(args, out)
    if dates:
        sessions = [
            s.with_date(date) for s, date in zip(sessions, dates, strict=True)
        ]
    if args.split:
        groups = split_sessions(sessions)
    else:
        check_alike(sessions)
        groups = {"": sessions}
    source = "--dates" if args.dates else None
    # All are tested, and their files made, before any is written: one too few
    # refuses the whole.
    documents = {
        name: MakeTrendDocument(
            make_timeline(group, source), args.level, args.repeatability
        )
        for name, group in groups.items()
    }
    files = {n: trend_files(d, args.html) for n, d in documents.items()}
    for name, document in documents.items():
        folder = MakeFolder(out / name) if len(groups) > 1 else out
        WriteTrend(folder, files[name])
        if not args.json:
            print(format_text(document))
            print(f"trend: {folder / 'trend.json'}")
            if args.html:
                print(f"page: {folder / 'trend.html'}")
    if args.json:
        found = list(documents.values())
        PrintJson(found[0] if len(found) == 1 else {"trends": found})
    return 0


@contextmanager
def _tell(name: str):
    """A bar of one folder's diagnosis."""
    with share_bar() as progress:
        yield lambda what, share: progress(f"{name}: {what}", share)


def _sessions(args: argparse.Namespace, out: Path) -> list:
    """The sessions of all folders; diagnoses that are made are written too."""
    from brace_drake.trend.diagnosed import LoadOrDiagnose, is_campaign

    folders = [Path(path) for path in args.folders]
    # A folder that is none is told before minutes are spent on others.
    for folder in folders:
        is_campaign(folder)
    scenario = name_scenario_option(args.scenario)
    diagram = find_diagram_option(args.diagram)
    sessions = []
    with open_workers_option(args) as workers:
        names = folder_names(args.folders)
        for folder, name in zip(folders, names, strict=True):
            what = (folder, workers, args.seed, scenario, diagram)
            session, document = LoadOrDiagnose(*what, partial(_tell, name))
            if document is not None:
                place = MakeFolder(out / "diagnoses" / name)
                WriteJson(place / "diagnosis.json", document)
            sessions.append(session)
    return sessions
