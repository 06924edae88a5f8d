"""The command `brace-drake evaluate`: policies beside controllers."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import (
    AddCommand,
    AddJobs,
    count_to,
    open_workers_option,
    positive,
)
from brace_drake.core.output import HoldFolder
from brace_drake.core.progress import share_bar

_EPILOG = """\
example:
  brace-drake evaluate runs/seed0/best.npz runs/seed1/best.npz \\
      runs/seed2/best.npz --out out/evaluation

Policies of the same task count as seeds of one training, those of other tasks
as rivals. They are compared with PIC, NPIC, MRAIC, VPIC and the best constant
stiffness that a search finds, on the nominal subject and on others. Readings
are exact and nothing is random. Writes table_1.csv (as in the paper),
unseen.csv, pushes.csv, constants.csv, figure_8.png to figure_13.png,
unseen.png, and all of it on one page, evaluation.html.
"""
# Subjects; each takes several pushes of several controllers.
_MOST_SUBJECTS = 10_000


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `evaluate`."""
    parser = AddCommand(
        subparsers,
        "evaluate",
        Run,
        help="compare policies with controllers, on unseen subjects too",
        description="Compares policies with controllers, without chance.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add(
        "policies",
        nargs="*",
        metavar="POLICY",
        help="files *.npz of training runs (default: the one that comes with"
        " the package)",
    )
    add("--out", required=True, metavar="DIR", help="folder for the results")
    add(
        "--subjects",
        type=count_to(_MOST_SUBJECTS),
        default=50,
        metavar="N",
        help="unseen subjects (default: 50)",
    )
    add(
        "--searched",
        type=count_to(_MOST_SUBJECTS),
        default=20,
        metavar="N",
        help="others, on which a constant stiffness is tuned (default: 20)",
    )
    add(
        "--seeds",
        type=positive,
        metavar="N",
        help="take the first N policies of each training (default: all)",
    )
    AddJobs(parser)


def Run(args: argparse.Namespace) -> int:
    """Evaluates, writes, and prints what it says."""
    from brace_drake.core.resources import policy_path
    from brace_drake.experiments import evaluate
    from brace_drake.experiments.evaluation_figures import WriteFigures
    from brace_drake.experiments.evaluation_page import WritePage
    from brace_drake.experiments.evaluation_table import WriteTables
    from brace_drake.experiments.evaluation_words import explain
    from brace_drake.learning.policy import LoadPolicy

    files = args.policies or [policy_path()]
    policies = evaluate.gather_policies([LoadPolicy(f) for f in files])
    if args.seeds:
        policies = tuple(c for c in policies if c.seed < args.seeds)
    out = HoldFolder(Path(args.out))
    with open_workers_option(args) as workers, share_bar() as progress:
        found = evaluate.evaluate(
            policies, workers, args.subjects, args.searched, args.seed, progress
        )
    WriteTables(out, found)
    WritePage(out, found, WriteFigures(out, found))
    for sentence in explain(found):
        print(sentence)
    print(f"page: {out / 'evaluation.html'}")
    print(f"tables: {out / 'table_1.csv'}, unseen.csv, pushes.csv")
    return 0
