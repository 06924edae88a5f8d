"""The command `brace-drake compare`: all controllers on one push."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import (
    AddCommand,
    AddMotion,
    AddNoiseSeed,
    MakeBar,
    load_motion,
)
from brace_drake.core.errors import BraceError, ScenarioError
from brace_drake.core.output import HoldFolder

_EPILOG = """\
example:
  brace-drake compare --out out/compare

Without SCENARIO it runs the paper's push of 10 mm in 12 s on the whole brace
with its second ring in contact (diagrams/paper_brace.scenario.yaml). Then it
runs the paper's own two scenarios of stage 2, and shows the paper's Table 1
beside them. Writes comparison.csv, comparison.md and comparison.png. Ends with
status 2 if a controller exceeds 50 N along y, or 20 mm along x and z.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `compare`."""
    parser = AddCommand(
        subparsers,
        "compare",
        Run,
        help="run every controller on the same push",
        description="Compares the brace's controllers on one reference.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "scenario",
        nargs="?",
        metavar="SCENARIO",
        help="file of the brace (default: the paper's push on all of it)",
    )
    AddMotion(
        parser,
        help="reference (*.csv), or a motion of the library"
        " (default: the paper's push)",
    )
    parser.add_argument(
        "--controllers",
        metavar="A,B",
        help="some of idc, pic, mraic, npic, vpic, pid (default: all)",
    )
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="folder for the table"
    )
    AddNoiseSeed(parser)


def Run(args: argparse.Namespace) -> int:
    """Runs the controllers, writes the table and prints it."""
    from brace_drake.core.resources import scenario_path
    from brace_drake.experiments import compare
    from brace_drake.experiments.comparison_table import WriteComparison
    from brace_drake.scenario.load import LoadScenario

    tags = _tags(args.controllers)
    path = args.scenario or scenario_path(compare.PAPER_BRACE)
    scenario = LoadScenario(path)
    if scenario.device != "brace":
        raise ScenarioError(
            f"{path}: compared are controllers of a 'brace', this is a"
            f" {scenario.device!r}"
        )
    motion = compare.LoadPush()
    if args.motion:
        motion = load_motion(args.motion, rings=(1, 2, 3))
    out = HoldFolder(Path(args.out))
    stages = ", ".join(str(i) for i in scenario.stages)
    setting = f"stages {stages}" if len(scenario.stages) > 1 else "one stage"
    runs = compare.compare_controllers(
        scenario, motion, tags, setting, args.noise_seed, MakeBar
    )
    paper_runs, reasons = [], []
    if not (args.scenario or args.motion):
        paper_runs = compare.RunPaper(args.noise_seed, MakeBar)
        paper = LoadScenario(scenario_path(compare.PAPER_PIC))
        reasons = compare.explain_table_1(paper_runs[0].score, paper)
    WriteComparison(out, runs, paper_runs, reasons)
    print((out / "comparison.md").read_text(encoding="utf-8"), end="")
    print(f"\ncomparison: {out / 'comparison.csv'}, .md, .png")
    outside = [r.tag for r in runs if not r.score.within_limits]
    if outside:
        raise BraceError(f"outside the limits: {', '.join(outside)}")
    return 0


def _tags(text: str | None) -> tuple[str, ...]:
    from brace_drake.scenario.controllers import TAGS

    if text is None:
        return TAGS
    tags = tuple(dict.fromkeys(part.strip() for part in text.split(",")))
    unknown = [tag for tag in tags if tag not in TAGS]
    if unknown:
        raise ScenarioError(
            f"--controllers: no controller {unknown[0]!r}; there are"
            f" {', '.join(TAGS)}"
        )
    return tags
