"""The command `brace-drake record`: a motion on a device, into a campaign."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.link_options import AddDevice, load_device_options

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
    parser.add_argument(
        "--motion", required=True, metavar="NAME|FILE", help="what to do"
    )
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="campaign's folder"
    )
    parser.add_argument(
        "--split",
        choices=("fit", "validation"),
        default="fit",
        help="what the run is for (default: fit)",
    )
    parser.add_argument("--subject", default="", metavar="TEXT")
    parser.add_argument(
        "--countdown", type=int, default=3, metavar="S", help="default: 3"
    )
    parser.set_defaults(run=Run)


def Run(args: argparse.Namespace) -> int:
    """Records one motion."""
    motion = load_motion(args.motion)
    scenario, limits = load_device_options(args)
    from brace_drake.operation.console import ReadKeys
    from brace_drake.operation.recorder import Recorder

    with ReadKeys() as keys:
        recorder = Recorder(
            args.port,
            scenario,
            limits,
            args.out,
            args.subject,
            args.baud,
            args.clear,
        )
        with recorder:
            run = recorder.Record(motion, args.split, args.countdown, keys)
    print(f"recorded: {Path(args.out) / run.entry['file']}, {run.rows} rows")
    return 0


def load_motion(text: str):
    """A motion of the library, or a reference in a file.

    Raises:
        CampaignError: Neither.
    """
    from brace_drake.twin.motion_library import MakeMotion, SafeMotion
    from brace_drake.twin.reference import COLUMNS
    from brace_drake.twin.reference_file import LoadReference

    if not (text.endswith(".csv") or Path(text).exists()):
        return MakeMotion(text)
    run = LoadReference(text)
    time = run.time_s - run.time_s[0]
    samples = run.stack(COLUMNS)
    return SafeMotion(
        run.name, f"from {text}", run.contact, run.motion, time, samples
    )
