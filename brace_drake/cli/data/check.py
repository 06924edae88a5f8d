"""The command `brace-drake check`: is a campaign fit for use?"""

from __future__ import annotations

import argparse
from dataclasses import asdict

from brace_drake.cli.options import AddCampaign, AddCommand, AddJson, PrintJson
from brace_drake.recording import CheckCampaign
from brace_drake.recording.findings import counted

_EPILOG = """\
example:
  brace-drake check campaigns/monday

Prints one line per problem. Ends with status 0 when there is no error
(warnings are allowed) and with 2 when there is one.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `check` to the command line."""
    parser = AddCommand(
        subparsers,
        "check",
        Run,
        help="find every problem of a recorded campaign",
        description="Finds every problem of a recorded campaign.",
        epilog=_EPILOG,
    )
    AddCampaign(parser)
    AddJson(parser)


def Run(args: argparse.Namespace) -> int:
    """Prints the problems and a summary; 2 when there are errors, else 0."""
    problems = CheckCampaign(args.campaign)
    errors = sum(problem.severity == "error" for problem in problems)
    warnings = len(problems) - errors
    if args.json:
        usable = not errors
        rows = [asdict(problem) for problem in problems]
        PrintJson({"usable": usable, "problems": rows})
        return 2 if errors else 0
    for problem in problems:
        print(problem)
    verdict = "not usable" if errors else "usable"
    print(
        f"{args.campaign}: {verdict}, {counted(errors, 'error')}, "
        f"{counted(warnings, 'warning')}"
    )
    return 2 if errors else 0
