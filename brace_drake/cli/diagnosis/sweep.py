"""The command `brace-drake sweep`: a twin over one number of its scenario."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import (
    AddCommand,
    AddJobCount,
    AddJson,
    AddMotion,
    PrintJson,
    count_to,
    finite,
    names,
    open_workers_option,
)
from brace_drake.core.output import HoldFolder
from brace_drake.core.progress import share_bar

_EPILOG = """\
example:
  brace-drake sweep diagrams/bench.scenario.yaml --number contact.stiffness \\
      --from 3000 --to 12000 --count 7 --log --motion push --out sweeps/push

A number has the path that it has in the file: torso.mass, one of an array as
torso.posture_stiffness[1], of an effect as effects.relaxation.KEY, in SI units.
Without --seeds readings are exact; with N of them each value is simulated N
times with the instruments' noise. Writes sweep.json, sweep.csv, sweep.png and
sweep.html. A value with which the twin breaks down has its reason in its row.
"""
# Values, or runs of each; that together they are not too many is told by the
# sweep.
_MOST_VALUES = 10_000


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `sweep`."""
    parser = AddCommand(
        subparsers,
        "sweep",
        Run,
        help="simulate a twin over one number of its scenario",
        description="Simulates a motion for each value of one number.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="file of a bench, brace, drive, pad or axis, *.scenario.yaml",
    )
    parser.add_argument(
        "--number",
        required=True,
        metavar="PATH",
        help="which number, as contact.stiffness or torso.mass",
    )
    for name, what in (("from", "first"), ("to", "last")):
        parser.add_argument(
            f"--{name}",
            dest=what,
            required=True,
            type=finite,
            metavar="VALUE",
            help=f"its {what} value, in the unit of the scenario",
        )
    parser.add_argument(
        "--count",
        type=count_to(_MOST_VALUES),
        default=11,
        metavar="N",
        help="how many values (default: 11)",
    )
    parser.add_argument(
        "--log", action="store_true", help="values by even ratios"
    )
    AddMotion(
        parser,
        required=True,
        help="motion of the library by name or a reference (*.csv); of a drive,"
        " pad or axis a recording (*.csv)",
    )
    parser.add_argument(
        "--seeds",
        type=count_to(_MOST_VALUES, 0),
        default=0,
        metavar="N",
        help="simulate with noise, N times each (default: exact readings)",
    )
    parser.add_argument(
        "--outcomes",
        type=names,
        metavar="A,B,C",
        help="what is told, as peak_force_N (default: all)",
    )
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="folder for the results"
    )
    AddJobCount(
        parser, "threads (default: all cores); results do not depend on it"
    )
    AddJson(parser)
    parser.set_defaults(cluster=None)


def Run(args: argparse.Namespace) -> int:
    """Simulates, writes, and prints a table and the files."""
    from brace_drake.scenario.load import LoadScenario
    from brace_drake.sweep.numbers import find_number
    from brace_drake.sweep.page import WriteSweep, format_text
    from brace_drake.sweep.runs import LoadMotion, make_simulator
    from brace_drake.sweep.sweep import Plan, check_runs, run_sweep, spaced

    scenario = LoadScenario(args.scenario)
    make_simulator(scenario)
    check_runs(args.count, args.seeds)
    plan = Plan(
        scenario,
        args.scenario,
        find_number(scenario, args.number, args.scenario),
        spaced(args.first, args.last, args.count, args.log),
        LoadMotion(args.motion, scenario),
        tuple(range(1, args.seeds + 1)),
        args.outcomes,
    )
    out = HoldFolder(Path(args.out))
    total = len(plan.values) * max(1, args.seeds)
    with open_workers_option(args) as workers, share_bar() as progress:
        document = run_sweep(
            plan,
            workers,
            lambda done: progress(plan.number.path, done / total),
        )
    WriteSweep(out, document)
    if args.json:
        PrintJson(document)
        return 0
    print(format_text(document))
    for name in ("sweep.json", "sweep.csv", "sweep.png", "sweep.html"):
        print(f"{name.partition('.')[2]}: {out / name}")
    return 0
