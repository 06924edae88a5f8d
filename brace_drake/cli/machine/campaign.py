"""The command `brace-drake campaign`: all runs that a diagnosis needs."""

from __future__ import annotations

import argparse
import shlex

from brace_drake.cli.machine.link_options import (
    AddDevice,
    AddRecording,
    OpenRecorder,
)
from brace_drake.cli.options import AddCommand
from brace_drake.recording.columns import BRACE

_EPILOG = """\
example:
  brace-drake campaign --port /dev/ttyACM0 --subject "phantom 2" --out monday
  brace-drake diagnose monday --out results/monday

Guides through free runs, then through runs with the torso. Some of them are for
validation alone. Started again on the same folder, it continues where it
stopped. A file can name other runs:
  format: brace-plan/1
  runs:
  - {motion: push}
  - {motion: push, repeat: true}
  - {motion: push_fast, split: validation}
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `campaign`."""
    parser = AddCommand(
        subparsers,
        "campaign",
        Run,
        help="record all runs that a diagnosis needs",
        description="Guides through a whole campaign on a device.",
        epilog=_EPILOG,
    )
    AddDevice(parser)
    parser.add_argument(
        "--plan",
        metavar="FILE",
        help="runs to record (default: the standard set)",
    )
    AddRecording(parser)


def Run(args: argparse.Namespace) -> int:
    """Records what is still missing of a plan."""
    from brace_drake.link.operation.campaign import (
        LoadPlan,
        RecordRuns,
        remaining_runs,
    )

    plan = LoadPlan(args.plan)
    with OpenRecorder(args) as recorder:
        left = remaining_runs(plan, recorder.journal.runs)
        RecordRuns(recorder, left, len(plan), args.countdown)
    out = shlex.quote(args.out)
    print(f"campaign: {args.out}, {len(left)} runs recorded")
    if recorder.journal.head["device"] == BRACE:
        return 0
    results = shlex.quote(args.out.rstrip("/") + "-results")
    print(f"next: brace-drake diagnose {out} --out {results}")
    return 0
