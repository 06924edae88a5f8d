"""The command line `brace-drake`."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import TYPE_CHECKING

# Two threads of ours and BLAS's own would fight over the cores; this must be
# set before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from brace_drake.core.errors import BraceError
from brace_drake.core.output import ReleaseFolders

if TYPE_CHECKING:
    import argparse

_COMMANDS = (
    "data.check",
    "diagnosis.fit",
    "diagnosis.validate",
    "diagnosis.diagnose",
    "diagnosis.simulate",
    "learning.compare",
    "diagnosis.plan",
    "diagnosis.personalize",
    "learning.train",
    "learning.predict",
    "learning.evaluate",
    "learning.payoff",
    "diagnosis.withheld",
    "machine.emulate",
    "machine.record",
    "machine.campaign",
    "machine.deploy",
    "diagnosis.twin",
    "data.import_",
    "learning.export",
    "data.doctor",
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
        status = args.run(args)
        if sys.stdout is not None:
            # What cannot be printed is found out here, and not at exit.
            sys.stdout.flush()
        return status
    except BraceError as error:
        return _Tell(str(error))
    except BrokenPipeError:
        _PrintNoMore()
        return 0
    except OSError as error:
        # A disk that is full or gone, as no part of ours has foreseen it.
        _PrintNoMore()
        return _Tell(str(error))
    except KeyboardInterrupt:
        print("brace-drake: stopped", file=sys.stderr)
        return 130
    finally:
        ReleaseFolders()


def _Tell(problem: str) -> int:
    print(f"brace-drake: {' '.join(problem.split())}", file=sys.stderr)
    return 2


def _PrintNoMore() -> None:
    """Keeps Python quiet about an output that takes no more."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def make_parser() -> argparse.ArgumentParser:
    """The parser with all subcommands."""
    # All that takes time to import comes where Ctrl-C is caught.
    import argparse
    import importlib.metadata

    from brace_drake.cli.options import OneLineParser

    parser = OneLineParser(
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
