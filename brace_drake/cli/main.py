"""The command line `brace-drake`."""

from __future__ import annotations

# All that takes time to import comes where Ctrl-C is caught.
import os
import signal
import sys

# Two threads of ours and BLAS's own would fight over the cores; this must be
# set before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator
    from types import ModuleType

# Folders of commands, in the order in which the help lists them.
_GROUPS = ("data", "library", "diagnosis", "learning", "machine")
_EPILOG = """\
exit codes:
  0    done
  2    a problem with input, machine or result; one line on standard error
  130  stopped by Ctrl-C or a signal; finished work is kept

examples:
  brace-drake check tests/data/example
  brace-drake diagnose tests/data/example --out out/demo
  brace-drake doctor
"""
# After so long, s, Ctrl-C is heard again, in case nobody has heard it.
_AGAIN = 0.2


def main(argv: list[str] | None = None) -> int:
    """Runs one command; without arguments prints what there is.

    Args:
        argv: Its words; those of the process by default, which then ends.

    Returns:
        0 when it went well, 2 with one line on standard error otherwise, 130
        after Ctrl-C.
    """
    stop = _Stop(argv is None)
    try:
        stop.Begin()
        return _Run(sys.argv[1:] if argv is None else argv)
    except BaseException as error:
        # Some libraries make another error of Ctrl-C.
        if not (stop.asked or isinstance(error, KeyboardInterrupt)):
            raise
        return stop.Tell()
    finally:
        stop.End()


def _LoadDevices() -> None:
    """Devices of installed packages; without any nothing is imported."""
    from importlib.metadata import entry_points

    if entry_points(group="brace_drake.devices"):
        from brace_drake.devices.registry import load_installed

        load_installed()


def _Run(given: list[str]) -> int:
    from brace_drake.core.errors import BraceError
    from brace_drake.core.output import ReleaseFolders

    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            # Names of files need not be text.
            stream.reconfigure(errors="backslashreplace")
    try:
        _CheckWords(given)
        args = make_parser().parse_args(given or ["--help"])
        # A help that is all that was asked for has ended by now.
        _LoadDevices()
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
        # A disk that is full or gone, where no part of ours has caught it.
        _PrintNoMore()
        return _Tell(str(error))
    finally:
        ReleaseFolders()


# Of the keyboard, the terminal, the system, and of what hands out time.
_SIGNALS = (
    "SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGXCPU", "SIGUSR1", "SIGUSR2",
)  # fmt: skip


class _Stop:
    """Ctrl-C: once to end a command in order, again to end it at once.

    A process that is told to end, or whose terminal goes, ends alike: what
    drives a device stops it first.

    Attributes:
        asked: Whether it was pressed.
    """

    def __init__(self, for_good: bool):
        """Argument: whether the process ends with the command."""
        self.asked = False
        self._for_good, self._before, self._told = for_good, {}, False
        self._hook = None

    def Begin(self) -> None:
        """Listens, unless Ctrl-C is ignored or heard by somebody else."""
        import atexit

        for name in _SIGNALS:
            number = getattr(signal, name, signal.SIGINT)
            if self._for_good:
                # Else one kills a process in the last of its cleaning up.
                atexit.register(signal.signal, number, signal.SIG_IGN)
            found = signal.getsignal(number)
            if found not in (signal.default_int_handler, signal.SIG_DFL):
                continue
            try:
                self._before[number] = signal.signal(number, self._Hear)
            except ValueError:
                return  # Only the main thread hears.
        self._hook, sys.unraisablehook = sys.unraisablehook, self._Swallow

    def End(self) -> None:
        """Listens no more; at the end of a process nothing more is raised."""
        if self._hook is not None:
            sys.unraisablehook = self._hook
        if self.asked and hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, before in self._before.items():
            signal.signal(number, self._Leave if self._for_good else before)

    def Tell(self) -> int:
        """The one line, and the status."""
        while not self._told:
            try:
                for number in self._before:
                    signal.signal(number, signal.SIG_IGN)
                print("brace-drake: stopped", file=sys.stderr, flush=True)
                self._told = True
            except KeyboardInterrupt:
                continue
            except OSError:
                break
        return 130

    def _Hear(self, *_) -> None:
        self.asked = True
        if hasattr(signal, "setitimer"):
            signal.signal(signal.SIGALRM, self._Remind)
            signal.setitimer(signal.ITIMER_REAL, _AGAIN, _AGAIN)
        raise KeyboardInterrupt

    def _Swallow(self, told) -> None:
        if not issubclass(told.exc_type, KeyboardInterrupt):
            self._hook(told)

    def _Remind(self, *_) -> None:
        """Raises again what somebody has swallowed, a library's import say."""
        error = sys.exception()
        while error and not isinstance(error, KeyboardInterrupt):
            error = error.__context__
        # Else it is on its way, and what cleans up must not be disturbed.
        if error is None and not self._told:
            raise KeyboardInterrupt

    def _Leave(self, *_) -> None:
        if not self._told:
            os.write(2, b"brace-drake: stopped\n")
        os._exit(130)


def _CheckWords(given: list[str]) -> None:
    """Refuses what a terminal would obey where it is printed."""
    from brace_drake.core.errors import ScenarioError, quoted

    for word in given:
        codes = {*map(ord, word)} - {ord("\t"), ord("\n")}
        if codes & {*range(0x20), *range(0x7F, 0xA0)}:
            raise ScenarioError(f"{quoted(word)} holds control characters")


def _Tell(problem: str) -> int:
    print(f"brace-drake: {' '.join(problem.split())}", file=sys.stderr)
    return 2


def _PrintNoMore() -> None:
    """Keeps Python quiet about an output that takes no more."""
    import contextlib

    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def make_parser() -> argparse.ArgumentParser:
    """The parser with all subcommands."""
    import argparse
    import importlib.metadata

    from brace_drake.cli.parser import OneLineParser

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
    import importlib
    from pathlib import Path

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
