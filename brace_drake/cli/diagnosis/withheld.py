"""The command `brace-drake withheld`: blind cases, answers, scores."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import (
    AddCommand,
    AddJobCount,
    count_to,
    finite,
)
from brace_drake.core.errors import BraceError
from brace_drake.core.output import HoldFolder, WriteFiles, format_json
from brace_drake.core.progress import open_bar

_EPILOG = """\
example:
  brace-drake withheld make --cases 40 --out cases --vault secret/vault.json
  brace-drake withheld answer cases --out answers
  brace-drake withheld score cases --vault secret/vault.json --answers answers

The cases come from an independent simulator of the bench, which shares no code
with the twin. Their truth is in the vault. SEALS.yaml, among the cases, commits
to the truth by hash. COMMITMENT, among the answers, commits to the answers.

A benchmark is a frozen set of cases that anyone can make and any method answer:
  brace-drake withheld make --benchmark bench-clean --out cases \\
      --vault secret/vault.json
  brace-drake withheld table cases --vault secret/vault.json \\
      --answers answers other_method.json
"""
# Cases, of which each takes seconds; a seed may be long, as it is a secret.
_MOST_CASES, _MOST_SEED = 10_000, 2**64 - 1


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `withheld` with its parts."""
    parser = AddCommand(
        subparsers,
        "withheld",
        None,
        help="put the diagnosis to a blind test",
        description="Puts the diagnosis to a blind test.",
        epilog=_EPILOG,
    )
    parts = parser.add_subparsers(metavar="PART", required=True)
    _add_make(parts)
    _add_answer(parts)
    _add_score(parts)
    _add_table(parts)


def _add_part(
    parts, name: str, run, what: str, arguments: str
) -> argparse.ArgumentParser:
    return AddCommand(
        parts,
        name,
        run,
        help=what,
        description=f"{what.capitalize()}.",
        epilog=f"example:\n  brace-drake withheld {name} {arguments}\n",
    )


def _add_make(parts: argparse._SubParsersAction) -> None:
    parser = _add_part(
        parts,
        "make",
        RunMake,
        "make sealed cases",
        "--cases 40 --out cases --vault secret/vault.json",
    )
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument(
        "--cases",
        type=count_to(_MOST_CASES),
        metavar="N",
        help="how many to make",
    )
    which.add_argument(
        "--benchmark",
        metavar="NAME",
        help="make a frozen set in place of cases drawn now, and compare the"
        " recordings with its checksum; bench-tiny is the smallest",
    )
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="folder for the cases"
    )
    parser.add_argument(
        "--vault",
        required=True,
        metavar="FILE",
        help="file for their truth, outside DIR",
    )
    parser.add_argument(
        "--seed",
        type=count_to(_MOST_SEED, 0),
        metavar="S",
        help="makes repeatable cases, which are then not blind (default:"
        " entropy of the operating system)",
    )
    parser.add_argument(
        "--tolerances",
        nargs="?",
        type=finite,
        const=1.0,
        metavar="FACTOR",
        help="machines are off by draws of so many times their tolerances,"
        " 0 to 5 (default: 0; 1 without FACTOR), and no fault is small",
    )
    AddJobCount(parser, "cases at a time (default: all cores)")


def _add_answer(parts: argparse._SubParsersAction) -> None:
    parser = _add_part(
        parts, "answer", RunAnswer, "diagnose all cases", "cases --out answers"
    )
    parser.add_argument("cases", metavar="DIR", help="folder of the cases")
    parser.add_argument(
        "--out",
        required=True,
        metavar="ANSWERS",
        help="folder for the diagnoses",
    )
    AddJobCount(parser, "cases at a time (default: all cores)")


def _add_score(parts: argparse._SubParsersAction) -> None:
    parser = _add_part(
        parts,
        "score",
        RunScore,
        "open the vault and compare the answers with the truth",
        "cases --vault secret/vault.json --answers answers",
    )
    parser.add_argument(
        "cases",
        nargs="+",
        metavar="DIR",
        help="folder of the cases; several are scored together",
    )
    for name, metavar, what in (
        ("--vault", "FILE", "vault"),
        (
            "--answers",
            "ANSWERS",
            "folder of the answers, or a file of any method's,",
        ),
    ):
        parser.add_argument(
            name,
            nargs="+",
            required=True,
            metavar=metavar,
            help=f"{what} of each folder of cases, in the same order",
        )
    _add_detectable(parser)
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="folder for score.json, score.txt and reliability.svg",
    )


def _add_table(parts: argparse._SubParsersAction) -> None:
    parser = _add_part(
        parts,
        "table",
        RunTable,
        "print a table of several methods' scores on the same cases",
        "cases --vault secret/vault.json --answers answers other.json",
    )
    parser.add_argument("cases", metavar="DIR", help="folder of the cases")
    parser.add_argument(
        "--vault", required=True, metavar="FILE", help="file of their truth"
    )
    parser.add_argument(
        "--answers",
        nargs="+",
        required=True,
        metavar="ANSWERS",
        help="a folder of answers, or a file, of each method",
    )
    _add_detectable(parser)


def _add_detectable(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--detectable",
        type=finite,
        default=0.3,
        metavar="F",
        help="noise floors above which a gap counts as detectable"
        " (default: 0.3)",
    )


def RunMake(args: argparse.Namespace) -> int:
    """Makes the cases; prints where they and their truth lie."""
    from brace_drake.withheld.benchmark import check_set, find_set
    from brace_drake.withheld.make import make_cases
    from brace_drake.withheld.seals import SEALS

    out, frozen = Path(args.out), None
    count, seed, tolerances = args.cases, args.seed, args.tolerances
    if args.benchmark is not None:
        if seed is not None or tolerances is not None:
            raise BraceError(
                "withheld make: --benchmark has a seed and tolerances of its"
                " own; --seed and --tolerances are for cases drawn now"
            )
        frozen = find_set(args.benchmark)
        count, seed = frozen.cases, frozen.seed
        tolerances = frozen.tolerances
    with open_bar(total=count, unit="case") as bar:
        make_cases(
            out,
            Path(args.vault),
            count,
            seed,
            lambda done: bar.update(done - bar.n),
            args.jobs,
            tolerances or 0.0,
        )
    print(f"cases: {out}, sealed by {out / SEALS}")
    print(f"truth: {args.vault}")
    if frozen is not None:
        print(f"checked: {check_set(out, frozen)}")
    return 0


def RunAnswer(args: argparse.Namespace) -> int:
    """Diagnoses the cases; prints each answer as it comes."""
    from brace_drake.withheld.answer import answer_cases
    from brace_drake.withheld.seals import COMMITMENT

    def tell(name: str, answer: str) -> None:
        print(f"{name}: {answer}", flush=True)

    answers = answer_cases(
        Path(args.cases), Path(args.out), args.jobs, progress=tell
    )
    failed = [case for case in answers.values() if case["error"]]
    for case in failed[:1]:
        print(f"{len(failed)} not answered, the first: {case['error']}")
    print(f"commitment: {Path(args.out) / COMMITMENT}")
    return 0


def RunScore(args: argparse.Namespace) -> int:
    """Prints the scores, and writes them where asked."""
    from brace_drake.withheld.score import load_judged, score
    from brace_drake.withheld.score_text import draw_reliability, format_score

    sets = (args.cases, args.vault, args.answers)
    if len({len(paths) for paths in sets}) > 1:
        raise BraceError(
            f"withheld score: {len(args.cases)} folders of cases,"
            f" {len(args.vault)} vaults and {len(args.answers)} folders of"
            " answers; each folder of cases has one of either"
        )
    judged = []
    for paths in zip(*sets, strict=True):
        judged += load_judged(*map(Path, paths))
    found = score(judged, args.detectable)
    text = format_score(found)
    print(text, end="")
    if args.out:
        out = HoldFolder(Path(args.out))
        WriteFiles(
            {
                out / "score.json": format_json(found),
                out / "score.txt": text,
                out / "reliability.svg": draw_reliability(found),
            }
        )
        print(f"score: {out / 'score.json'}")
    return 0


def RunTable(args: argparse.Namespace) -> int:
    """Prints a row for each method."""
    from brace_drake.withheld.score import load_judged, method_of, score
    from brace_drake.withheld.table import format_table

    cases, vault, scores = Path(args.cases), Path(args.vault), {}
    for answers in map(Path, args.answers):
        method = method_of(answers)
        if method in scores:
            raise BraceError(
                f"withheld table: two methods are called {method}; name one"
                " of them anew"
            )
        judged = load_judged(cases, vault, answers)
        scores[method] = score(judged, args.detectable)
    print(format_table(scores), end="")
    return 0
