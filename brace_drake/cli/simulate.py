"""The command `brace-drake simulate`: a recording by the Drake diagram."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.errors import ScenarioError

_EPILOG = """\
example:
  brace-drake simulate results/monday/repaired.scenario.yaml \\
      --motion results/monday/next_run.csv --out simulated/monday

The motion is a file with the columns time_s, ring2_y_desired_m,
ring2_vy_desired_m_s and ring2_ay_desired_m_s2, or a name of the library. Where
a file's name begins with "free", or its column `contact` is 0, the torso is
absent. What is written is a campaign with that one run.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `simulate`."""
    parser = subparsers.add_parser(
        "simulate",
        help="record a motion with the twin of a scenario",
        description="Runs the Drake diagram of a scenario over a reference.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="file of the bench, *.scenario.yaml",
    )
    parser.add_argument(
        "--motion",
        required=True,
        metavar="FILE|NAME",
        help="reference (*.csv), or a motion of the library",
    )
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="campaign folder to make"
    )
    parser.add_argument(
        "--noise-seed",
        type=_not_negative,
        metavar="N",
        help="of the instruments' noise (default: exact readings)",
    )
    parser.set_defaults(run=Run)


def Run(args: argparse.Namespace) -> int:
    """Simulates and writes a campaign; prints where."""
    from brace_drake.scenario.bench import DEVICE
    from brace_drake.scenario.load import LoadScenario

    scenario = LoadScenario(args.scenario)
    if scenario.device != DEVICE:
        raise ScenarioError(
            f"{args.scenario}: simulated is {DEVICE!r}, this is a"
            f" {scenario.device!r}"
        )
    run = _load_motion(args.motion)
    from brace_drake.campaign import Campaign, WriteCampaign
    from brace_drake.simulate import RecordBench

    out = Path(args.out)
    recorded = RecordBench(scenario, run, args.noise_seed)
    rate = 1.0 / scenario.sensors.log_period
    subject = f"twin of {Path(args.scenario).name}"
    WriteCampaign(Campaign(out, DEVICE, rate, subject, (recorded,)), out)
    seconds = recorded.time_s[-1]
    print(f"campaign: {out}, {recorded.file}, {seconds:.3f} s")
    return 0


def _load_motion(text: str):
    from brace_drake.twin.motion_library import MakeMotion
    from brace_drake.twin.reference_file import LoadReference

    if text.endswith(".csv") or Path(text).exists():
        return LoadReference(text)
    return MakeMotion(text).run


def _not_negative(text: str) -> int:
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError("must not be negative")
    return value
