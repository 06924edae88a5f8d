"""The command line `brace-drake`."""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

# Two threads of ours and BLAS's own would fight over the cores; this must be
# set before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from brace_drake.core.errors import BraceError
from brace_drake.core.output import ReleaseFolders

if TYPE_CHECKING:
    import argparse

# Folders of commands, in the order in which the help lists them.
_GROUPS = ("data", "diagnosis", "learning", "machine")
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
    """Runs one command; without arguments prints what there is.

    Returns:
        0 when it went well, 2 with one line on standard error otherwise, 130
        after Ctrl-C.
    """
    try:
        given = sys.argv[1:] if argv is None else argv
        args = make_parser().parse_args(given or ["--help"])
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
    for module in _find_commands():
        module.AddParser(subparsers)
    return parser


def _find_commands() -> Iterator[ModuleType]:
    """The modules that add a command, group by group."""
    for group in _GROUPS:
        folder = Path(__file__).parent / group
        for file in sorted(folder.glob("[a-z]*.py")):
            name = f"brace_drake.cli.{group}.{file.stem}"
            module = importlib.import_module(name)
            if hasattr(module, "AddParser"):
                yield module
    yield importlib.import_module("brace_drake.cli.completion")


if __name__ == "__main__":
    sys.exit(main())
