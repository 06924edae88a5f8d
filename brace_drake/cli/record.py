"""The command `brace-drake record`: a motion on a device, into a campaign."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.link_options import (
    AddDevice,
    AddRecording,
    OpenRecorder,
    load_device_motion,
)
from brace_drake.cli.options import AddMotion

_EPILOG = """\
example:
  brace-drake record --port /dev/ttyACM0 --motion push --out recordings/monday

The motion is a name of the library (push, stairs, reversal, multisine,
quiet_hold, free_reversal ...) or a reference (*.csv). What is in the folder
stays; a motion that is there already is recorded as its repeat. Any key stops;
so does Ctrl-C. A crash or an unplugged device leaves a shorter recording.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `record`."""
    parser = subparsers.add_parser(
        "record",
        help="run a motion on a device and record it",
        description="Drives a device through a motion and records it.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    AddDevice(parser)
    AddMotion(parser, required=True)
    AddRecording(parser)
    parser.add_argument(
        "--split",
        choices=("fit", "validation"),
        default="fit",
        help="what the run is for (default: fit)",
    )
    parser.set_defaults(run=Run)


def Run(args: argparse.Namespace) -> int:
    """Records one motion."""
    from brace_drake.operation.console import ReadKeys

    motion = load_device_motion(args.motion)
    with ReadKeys() as keys, OpenRecorder(args) as recorder:
        run = recorder.Record(motion, args.split, args.countdown, keys)
    print(f"recorded: {Path(args.out) / run.entry['file']}, {run.rows} rows")
    return 0
