"""The command `brace-drake completion`: what a shell completes."""

from __future__ import annotations

import argparse

import shtab

from brace_drake.cli.options import AddCommand

_EPILOG = """\
example:
  brace-drake completion bash

Prints a script for the shell; put it where the shell looks for such scripts,
for bash ~/.local/share/bash-completion/completions/brace-drake.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `completion`."""
    parser = AddCommand(
        subparsers,
        "completion",
        Run,
        help="print a script that completes commands in the shell",
        description="Prints a script that completes commands in the shell.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "shell", choices=shtab.SUPPORTED_SHELLS, help="shell that is in use"
    )


def Run(args: argparse.Namespace) -> int:
    """Prints the script."""
    from brace_drake.cli.main import make_parser

    print(shtab.complete(make_parser(), shell=args.shell))
    return 0
