"""The command `brace-drake paper`: Table 1 and Figures 8 to 13."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import AddCommand
from brace_drake.core.output import HoldFolder

_EPILOG = """\
example:
  brace-drake paper --out out/paper
  brace-drake paper --fit --policy runs/mine/best.npz --out out/paper

Pushes a torso that no spring holds and that leans on the pad
(diagrams/paper_leaning_torso.scenario.yaml) by PIC, by the paper's mean
stiffness and by a policy, on stage 2 and on the whole brace, and the torso with
a posture spring beside it. Readings are exact, nothing is random. --fit finds
lean and load of the torso anew from PIC's row of the paper's Table 1. Writes
table_1.csv, table_1.md and figure_8.png to figure_13.png.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `paper`."""
    parser = AddCommand(
        subparsers,
        "paper",
        Run,
        help="the paper's Table 1 on a torso that leans on the pad",
        description="Runs the paper's Table 1 on its own kind of torso.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("--out", required=True, metavar="DIR", help="folder for the results")
    add(
        "--fit",
        action="store_true",
        help="fit the torso's three numbers to the paper's PIC anew",
    )
    add(
        "--policy",
        metavar="FILE",
        help="policy of RLPIC, as train writes it (default: the package's,"
        " trained on this torso)",
    )


def Run(args: argparse.Namespace) -> int:
    """Fits if asked to, runs, writes, and prints what it says."""
    from brace_drake.core.resources import policy_path
    from brace_drake.experiments.paper_torso.lean import fit_lean, leaning_task
    from brace_drake.experiments.paper_torso.pushes import run_pushes
    from brace_drake.experiments.paper_torso.write import WritePaper, explain
    from brace_drake.learning.policy import LoadPolicy
    from brace_drake.learning.task import load_task_scenario

    policy = LoadPolicy(args.policy or policy_path("rlpic_leaning.npz"))
    scenario, fitted = load_task_scenario(leaning_task()), None
    out = HoldFolder(Path(args.out))
    if args.fit:
        fitted = fit_lean(scenario)
        scenario = fitted.lean.apply(scenario)
    pushes = run_pushes(policy, scenario)
    WritePaper(out, pushes, scenario, fitted)
    for sentence in explain(pushes, scenario, fitted):
        print(sentence)
    print(f"table: {out / 'table_1.md'}, table_1.csv; figure_8.png and on")
    return 0
