"""Options that commands share, with the same words for the same things."""

from __future__ import annotations

import argparse
import contextlib
import math
import os
from collections.abc import Callable, Iterator
from pathlib import Path

from brace_drake.core.errors import PolicyError, quoted
from brace_drake.core.output import WriteJson, format_json
from brace_drake.core.parallel import Workers, open_workers
from brace_drake.core.progress import share_bar

# Counts beyond which no work ends, unless an option has closer limits; threads
# that no machine has; what seeds every generator in use, numpy's old one too.
_MOST, _MOST_JOBS, _MOST_SEED, _MOST_REAL = 1_000_000, 1024, 2**32 - 1, 1e9


def AddCommand(
    subparsers: argparse._SubParsersAction,
    name: str,
    run: Callable[[argparse.Namespace], int] | None,
    **words: str,
) -> argparse.ArgumentParser:
    """Adds a subcommand.

    Args:
        subparsers: Of the command line.
        name: Of the command.
        run: Returns its status; None where its parts have their own.
        words: Its help, description and epilog, which stays as written.
    """
    parser = subparsers.add_parser(
        name, formatter_class=argparse.RawDescriptionHelpFormatter, **words
    )
    parser.set_defaults(run=run)
    return parser


def AddCampaign(
    parser: argparse.ArgumentParser, name: str = "campaign", **options
) -> None:
    """Adds the positional CAMPAIGN."""
    help_text = "folder with campaign.yaml and its recordings"
    parser.add_argument(
        name, metavar="CAMPAIGN", **{"help": help_text, **options}
    )


def AddJobCount(parser: argparse.ArgumentParser, help_text: str) -> None:
    """Adds --jobs alone."""
    parser.add_argument(
        "--jobs",
        type=count_to(_MOST_JOBS),
        default=os.cpu_count() or 1,
        metavar="N",
        help=help_text,
    )


def AddJobs(parser: argparse.ArgumentParser) -> None:
    """Adds --jobs, --cluster and --seed."""
    AddJobCount(
        parser, "threads (default: all cores); the results are the same"
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="Dask scheduler to run on, as in tcp://host:8786; the results"
        " are the same",
    )
    parser.add_argument(
        "--seed",
        type=not_negative,
        default=0,
        metavar="S",
        help="start of all random draws (default: 0)",
    )


def open_workers_option(args: argparse.Namespace) -> Workers:
    """Workers of --jobs or --cluster; a context manager."""
    return open_workers(args.jobs, args.cluster)


def AddScenario(
    parser: argparse.ArgumentParser,
    help_text: str = "file of the nominal twin (default: the one that"
    " campaign.yaml names, else the package's)",
) -> None:
    """Adds --scenario."""
    parser.add_argument("--scenario", metavar="FILE", help=help_text)


def AddDiagram(parser: argparse.ArgumentParser) -> None:
    """Adds --diagram."""
    parser.add_argument(
        "--diagram",
        metavar="MODULE:FUNCTION",
        help="function that makes the nominal Drake diagram, as in"
        " arm.py:MakeArm; for campaigns whose device is a diagram",
    )


def find_diagram_option(name: str | None):
    """The function of --diagram, None without."""
    if name is None:
        return None
    from brace_drake.devices.diagram.factory import find_factory

    return find_factory(name)


def AddJson(parser: argparse.ArgumentParser) -> None:
    """Adds --json."""
    parser.add_argument(
        "--json",
        action="store_true",
        help="print one JSON document on standard output and nothing else",
    )


def PrintJson(document: dict) -> None:
    """Prints what --json asks for."""
    print(format_json(document), end="")


def TellDocument(
    args: argparse.Namespace,
    document: dict,
    out: Path | None,
    what: str,
    describe: Callable[[dict], str],
) -> None:
    """Writes WHAT.json where --out asks for it, and prints a document.

    Args:
        args: With `json`: it is printed alone, as JSON.
        document: What was found.
        out: Folder of --out.
        what: In a word.
        describe: What people read instead of JSON.
    """
    file = None if out is None else out / f"{what}.json"
    if file is not None:
        WriteJson(file, document)
    if args.json:
        PrintJson(document)
        return
    print(describe(document))
    if file is not None:
        print(f"{what}: {file}")


def name_scenario_option(path: str | None):
    """The scenario of --scenario with its file and hash; None without."""
    if path is None:
        return None
    from brace_drake.devices.nominal_scenario import load_given

    return load_given(path)


def scenario_note(campaign, used: dict) -> str:
    """Which scenario was used, and who has named it.

    Args:
        campaign: Loaded.
        used: Provenance of the scenario, see `NominalScenario.describe`.
    """
    from brace_drake.recording.manifest import MANIFEST

    if used["named_by"] == MANIFEST:
        return f"scenario: {used['file']}, named by {MANIFEST}"
    if used["file"] is None:
        return "scenario: none named, the package's own"
    named = campaign.scenario
    text = f"scenario: {used['file']}, by --scenario"
    return f"{text}, not {named.name} of {MANIFEST}" if named else text


def AddMotion(parser: argparse.ArgumentParser, **options) -> None:
    """Adds --motion."""
    parser.add_argument(
        "--motion",
        metavar="FILE|NAME",
        **{"help": "reference (*.csv), or a motion of the library", **options},
    )


def names_file(text: str) -> bool:
    """Whether a --motion is a reference's file, not a name of the library."""
    return text.endswith(".csv") or Path(text).is_file()


def load_motion(text: str, rings: tuple[int, ...] = (2,)):
    """The reference of --motion, as a run that is not recorded yet."""
    from brace_drake.devices.motions.library import MakeMotion
    from brace_drake.devices.motions.reference import LoadReference

    if names_file(text):
        return LoadReference(text, rings)
    return MakeMotion(text).run


@contextlib.contextmanager
def MakeBar(run, label: str = "") -> Iterator[Callable[[float], None]]:
    """A bar of a run's simulated time; yields what is told the time, s."""
    end = float(run.time_s[-1] - run.time_s[0])
    with share_bar() as progress:
        yield lambda time: progress(label or run.name, time / end)


def AddNoiseSeed(parser: argparse.ArgumentParser) -> None:
    """Adds --noise-seed."""
    parser.add_argument(
        "--noise-seed",
        type=not_negative,
        metavar="N",
        help="seed of the instruments' noise (default: exact readings)",
    )


def check_training_extra() -> None:
    """Raises PolicyError where what training needs is not installed."""
    try:
        import stable_baselines3  # noqa: F401
        import torch  # noqa: F401
    except ImportError as error:
        raise PolicyError(
            f"training needs {error.name}: pip install -e '.[train]'"
        ) from error


def positive(text: str) -> int:
    """A whole number from 1 to what no command could work off."""
    return _whole(text, 1, _MOST)


def not_negative(text: str) -> int:
    """A whole number from 0 to the largest that seeds random draws."""
    return _whole(text, 0, _MOST_SEED)


def count_to(most: int, least: int = 1) -> Callable[[str], int]:
    """Reads a whole number within limits, as the type of an option."""
    return lambda text: _whole(text, least, most)


def _whole(text: str, least: int, most: int) -> int:
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if not least <= value <= most:
        raise argparse.ArgumentTypeError(
            f"{quoted(text)} is not a whole number of at least {least} and at"
            f" most {most}"
        )
    return value


def _real(text: str) -> float:
    """The number that a text is, NaN where it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def finite(text: str) -> float:
    """A number that is neither infinite nor none."""
    value = _real(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{quoted(text)} is not a number")
    return value


def positive_real(text: str) -> float:
    """A number above 0, no larger than what a clock can wait for."""
    value = _real(text)
    if not 0.0 < value <= _MOST_REAL:
        raise argparse.ArgumentTypeError(
            f"{quoted(text)} is not a number above 0 and at most {_MOST_REAL:g}"
        )
    return value


def names(text: str) -> str:
    """Names with commas between, one at least."""
    if not text.replace(",", "").strip():
        raise argparse.ArgumentTypeError(
            f"{quoted(text)} names nothing; allowed: one name or several with"
            " commas between, as in A,B,C"
        )
    return text
