"""The command line `brace-drake`."""

from __future__ import annotations

import argparse
import importlib
import importlib.metadata
import os
import sys

# Two threads of ours and BLAS's own would fight over the cores; this must be
# set before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from brace_drake.errors import BraceError

_COMMANDS = (
    "check",
    "fit",
    "validate",
    "diagnose",
    "simulate",
    "compare",
    "plan",
    "personalize",
    "train",
    "predict",
    "evaluate",
    "payoff",
    "withheld",
    "emulate",
    "record",
    "campaign",
    "deploy",
    "twin",
    "import_",
    "export",
    "doctor",
    "completion",
)
_EPILOG = """\
exit codes:
  0    done
  2    a problem with input, machine or result; one line on standard error
  130  stopped by Ctrl-C; what was done until then is kept

examples:
  brace-drake check tests/data/example
  brace-drake diagnose tests/data/example --out out/demo
  brace-drake doctor
"""


def main(argv: list[str] | None = None) -> int:
    """Runs one command.

    Returns:
        0 when it went well, 2 with one line on standard error otherwise, 130
        after Ctrl-C.
    """
    try:
        args = make_parser().parse_args(argv)
        return args.run(args)
    except BraceError as error:
        print(f"brace-drake: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # The reader of our output has gone; keep Python quiet about it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        print("brace-drake: stopped", file=sys.stderr)
        return 130


def make_parser() -> argparse.ArgumentParser:
    """The parser with all subcommands."""
    parser = argparse.ArgumentParser(
        prog="brace-drake",
        description="Digital twin of a robotic scoliosis brace that says why"
        " it differs from the real one. Research software, not a medical"
        " device.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--version",
        action="version",
        version=importlib.metadata.version("brace_drake"),
    )
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in _COMMANDS:
        module = importlib.import_module(f"brace_drake.cli.{command}")
        module.AddParser(subparsers)
    return parser


if __name__ == "__main__":
    sys.exit(main())
