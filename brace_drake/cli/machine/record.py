"""The command `brace-drake record`: a motion on a device, into a campaign."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.machine.link_options import (
    AddDevice,
    AddRecording,
    OpenRecorder,
    load_device_motion,
    load_device_options,
)
from brace_drake.cli.options import AddCommand, AddMotion
from brace_drake.core.errors import CampaignError

_EPILOG = """\
example:
  brace-drake record --port /dev/ttyACM0 --motion push --out recordings/monday

The motion is a name of the library (push, stairs, reversal, multisine,
quiet_hold, free_reversal ...), a reference (*.csv), or a plan of runs (*.yaml,
see `brace-drake campaign --help`). Of a plan, all runs are recorded. On a
brace, ring 2 or the ring of --ring follows the motion, and the others are held.
A reference may have columns of each ring. The folder's recordings stay. A
motion that is there already is recorded as its repeat; in a plan, if the plan
says so. Any key stops, and so does Ctrl-C. A crash or an unplugged device
leaves a shorter recording.
"""
_PLANS = (".yaml", ".yml")


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `record`."""
    parser = AddCommand(
        subparsers,
        "record",
        Run,
        help="run a motion on a device and record it",
        description="Drives a device through a motion and records it.",
        epilog=_EPILOG,
    )
    AddDevice(parser)
    AddMotion(
        parser,
        required=True,
        help="reference (*.csv), motion of the library, or plan (*.yaml)",
    )
    AddRecording(parser)
    parser.add_argument(
        "--split",
        choices=("fit", "validation"),
        help="what the run is for (default: fit)",
    )


def Run(args: argparse.Namespace) -> int:
    """Records one motion, or all runs of a plan."""
    if args.motion.endswith(_PLANS):
        return _RecordPlan(args)
    from brace_drake.link.operation.console import ReadKeys

    scenario, _ = load_device_options(args)
    motion = load_device_motion(args.motion, scenario.stages, args.ring)
    with ReadKeys() as keys, OpenRecorder(args) as recorder:
        run = recorder.Record(motion, args.split or "fit", args.countdown, keys)
    print(f"recorded: {Path(args.out) / run.entry['file']}, {run.rows} rows")
    return 0


def _RecordPlan(args: argparse.Namespace) -> int:
    from brace_drake.link.operation.campaign import LoadPlan, RecordRuns

    if args.split is not None:
        raise CampaignError(
            f"--split {args.split}: each run of {args.motion} has its own"
        )
    plan = LoadPlan(args.motion)
    with OpenRecorder(args) as recorder:
        RecordRuns(
            recorder, list(enumerate(plan, 1)), len(plan), args.countdown
        )
    print(f"recorded: {args.out}, {len(plan)} runs")
    return 0
