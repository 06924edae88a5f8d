"""The command `brace-drake payoff`: does closing the gap pay?"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from brace_drake.cli.options import (
    AddCommand,
    AddJobs,
    check_training_extra,
    count_to,
    names,
    open_workers_option,
    positive,
    positive_real,
)

_EPILOG = """\
example:
  brace-drake payoff --out out/payoff
  brace-drake payoff --out out/payoff --causes command_delay --episodes 200

For each cause: record a campaign of the independent simulator with that cause,
diagnose it, train one policy on the nominal and one on the repaired twin. Then
push the simulator under both policies and under PIC. Started again with the
same options, it continues with what the folder has. Writes payoff.yaml (the
options), payoff.csv and payoff.md. Needs pip install -e '.[train]'.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `payoff`."""
    parser = AddCommand(
        subparsers,
        "payoff",
        Run,
        help="compare policies trained on the nominal and the repaired twin",
        description="Measures what closing the gap is worth to a policy.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("--out", required=True, metavar="DIR", help="folder for the results")
    add(
        "--causes",
        type=names,
        metavar="A,B",
        help="effects to hide and repair (default:"
        " coulomb_friction,command_delay,relaxation)",
    )
    add(
        "--severity",
        choices=("small", "medium", "large"),
        default="large",
        help="size of these effects (default: large)",
    )
    add(
        "--episodes",
        type=positive,
        default=1000,
        metavar="N",
        help="budget of each training (default: 1000)",
    )
    add(
        "--force-limit",
        type=positive_real,
        default=20.0,
        metavar="N",
        help="F_max of the reward (default: 20; the bench's subject is stiffer"
        " than the paper's)",
    )
    add(
        "--pushes",
        type=count_to(1000),
        default=3,
        metavar="N",
        help="pushes of each controller on each machine (default: 3)",
    )
    AddJobs(parser)


def Run(args: argparse.Namespace) -> int:
    """Runs the experiment and prints its table."""
    check_training_extra()
    from brace_drake.experiments.transfer import experiment
    from brace_drake.experiments.transfer.table import WriteTransfer
    from brace_drake.learning.training.numbers import TrainingNumbers
    from brace_drake.learning.training.train import TrainPolicy

    out = Path(args.out)
    numbers = TrainingNumbers(episodes=args.episodes, seed=args.seed)
    options = experiment.TransferOptions(
        args.severity, args.force_limit, args.seed
    )
    causes = experiment.CAUSES
    if args.causes is not None:
        causes = args.causes.split(",")
    with open_workers_option(args) as workers:
        outcomes = experiment.run_transfer(
            out,
            lambda folder, task: TrainPolicy(folder, task, numbers),
            workers,
            options,
            causes,
            args.pushes,
            lambda what: print(what, file=sys.stderr, flush=True),
        )
    WriteTransfer(out, outcomes)
    print((out / "payoff.md").read_text(encoding="utf-8"), end="")
    return 0
