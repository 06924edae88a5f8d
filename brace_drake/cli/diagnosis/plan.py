"""The command `brace-drake plan`: what a campaign could not tell apart."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import (
    AddCommand,
    AddJobs,
    AddJson,
    AddScenario,
    TellDocument,
    names,
)
from brace_drake.core.output import HoldFolder

_EPILOG = """\
example:
  brace-drake plan --motions push,stairs,free_reversal --out plans/monday

Every effect of the library is put into the twin at the size that makes a gap of
one noise floor, and the subject's parameters are fitted to it. What is left is
its signature. Two effects with parallel signatures could not be told apart.
Nothing has to be recorded for this.
"""

# Floors of gap below which a size has met its limit; from 0.8 to 1.25 are one.
_SHORT = 0.8


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `plan`."""
    parser = AddCommand(
        subparsers,
        "plan",
        Run,
        help="say which effects planned runs could not tell apart",
        description="Says which effects planned runs could not tell apart.",
        epilog=_EPILOG,
    )
    source = parser.add_mutually_exclusive_group()
    source.add_argument(
        "--motions",
        type=names,
        metavar="A,B,C",
        help="motions of the library (default: those of a common campaign)",
    )
    source.add_argument(
        "--references",
        metavar="DIR",
        help="folder of references (*.csv) or a campaign",
    )
    parser.add_argument(
        "--effects",
        type=names,
        metavar="A,B,C",
        help="effects to put in (default: all of the library)",
    )
    parser.add_argument(
        "--without",
        type=names,
        metavar="A,B,C",
        help="effects to leave out (default: none)",
    )
    parser.add_argument("--out", metavar="DIR", help="folder for plan.json")
    AddScenario(parser)
    AddJobs(parser)
    AddJson(parser)


def Run(args: argparse.Namespace) -> int:
    """Plans, prints a table, and writes plan.json where asked."""
    out = HoldFolder(Path(args.out)) if args.out else None
    from brace_drake.results.plans import plan

    found = plan(
        args.motions,
        references=args.references,
        scenario=args.scenario,
        effects=args.effects,
        without=args.without,
        jobs=args.jobs,
        cluster=args.cluster,
        seed=args.seed,
    ).document
    TellDocument(args, found, out, "plan", format_plan)
    return 0


def format_plan(plan: dict) -> str:
    """The plan as a table, its pairs, and what stays undetermined."""
    rows, cosines = plan["effects"], plan["cosines"]
    width = max((len(r["effect"]) for r in rows), default=6)
    lines = [
        f"runs: {', '.join(plan['runs'])}",
        f"{'effect':{width}}  {'size':>10} {'gap':>5} {'least':>10}"
        f"  {'closest':{width}} |cos|  parameter",
    ]
    for i, row in enumerate(rows):
        name = row["effect"].split(" (")[0]
        near = [
            (cosines[i][j], other["effect"])
            for j, other in enumerate(rows)
            if other["effect"].split(" (")[0] != name
        ]
        cosine, closest = max(near, default=(0.0, "-"))
        least = row["least_size"]
        seen = f"{least:10.2g}" if least is not None else f"{'never':>10}"
        lines.append(
            f"{row['effect']:{width}}  {row['size']:10.3g}"
            f" {row['gap_floors']:5.2f} {seen}  {closest:{width}}"
            f" {cosine:5.2f}  {row['leading']}"
        )
    lines.append(
        "size: makes a gap of about one floor; least: can be seen; both in the"
        " unit that ends the parameter's name"
    )
    short = [r["effect"] for r in rows if r["gap_floors"] < _SHORT]
    if short:
        lines.append(f"limited before one floor: {', '.join(short)}")
    lines += _pair_lines(plan)
    lines += [f"cannot be seen: {name}" for name in plan["unseen"]]
    lines += [f"the twin breaks down with {name}" for name in plan["broken"]]
    return "\n".join([*lines, *_open_lines(plan)])


def _pair_lines(plan: dict) -> list[str]:
    limit = plan["inseparable_above"]
    if not plan["pairs"]:
        return [f"no two effects are alike (|cos| above {limit})"]
    return [
        f"not told apart: {' and '.join(p['effects'])}"
        f" (|cos| {p['cosine']:.3f}): {p['reason']}"
        for p in plan["pairs"]
    ]


def _open_lines(plan: dict) -> list[str]:
    lines = []
    for row in plan["undetermined"]:
        error = row["standard_error"]
        doubt = "not at all" if error is None else f"+- {error:.2g}"
        lines.append(
            f"not determined: {row['parameter']} of {row['of']},"
            f" {row['value']:.3g} {row['unit']} {doubt}"
        )
    return lines
