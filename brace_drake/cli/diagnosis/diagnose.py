"""The command `brace-drake diagnose`: where, which, how far."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from brace_drake.cli.choice import AddChoice, choice_options
from brace_drake.cli.options import (
    AddCampaign,
    AddCommand,
    AddDiagram,
    AddJobs,
    AddJson,
    AddScenario,
    PrintJson,
    find_diagram_option,
    name_scenario_option,
    scenario_note,
)
from brace_drake.core.errors import BraceError
from brace_drake.core.output import HoldFolder, MakeFolder
from brace_drake.core.places import real_path
from brace_drake.recording import LoadCampaign

_EPILOG = """\
example:
  brace-drake diagnose campaigns/monday --out results/monday

Writes diagnosis.json and report.html into the folder. If effects were found, it
writes the twin with them, repaired.scenario.yaml, for --scenario. If causes
cannot be told apart, it writes next_run.csv, the safe motion that separates
them best. Nothing is estimated on validation runs. They show how far the gap
closes. For a paper, --pdf adds report.pdf of one page, --figures svg the
figures as files, and --tables latex the tables.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `diagnose`."""
    parser = AddCommand(
        subparsers,
        "diagnose",
        Run,
        help="say where the gap lies, what causes it, how far it shrinks",
        description="Diagnoses the gap between twin and recording.",
        epilog=_EPILOG,
    )
    AddCampaign(parser, "campaigns", nargs="+")
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="folder for the results"
    )
    AddScenario(parser)
    AddDiagram(parser)
    AddChoice(parser)
    AddJobs(parser)
    AddJson(parser)
    parser.add_argument(
        "--pdf", action="store_true", help="write report.pdf, one page, as well"
    )
    parser.add_argument(
        "--figures",
        choices=("svg", "png", "pdf"),
        help="write the figures of the report as files of this format as well",
    )
    parser.add_argument(
        "--tables",
        choices=("csv", "latex"),
        help="write the tables of the report as files as well",
    )


def Run(args: argparse.Namespace) -> int:
    """Diagnoses and writes; prints the verdicts and the files."""
    if len(args.campaigns) > 1:
        return _RunMany(args)
    campaign = LoadCampaign(args.campaigns[0])
    out = HoldFolder(Path(args.out))
    scenario = name_scenario_option(args.scenario)
    diagram = find_diagram_option(args.diagram)
    document, more = _Diagnose(campaign, scenario, diagram, out, args)
    if args.json:
        PrintJson(document)
        return 0
    verdict = document["verdict"]
    print(verdict["sentence"])
    print(f"certainty: {_certainty(verdict)}")
    _PrintRemedies(verdict["effects"])
    for text in document["warnings"]:
        # What `check` tells says itself how severe it is.
        is_told = text.startswith(("warning: ", "error: "))
        print(text if is_told else f"warning: {text}")
    print(scenario_note(campaign, document["provenance"]["scenario"]))
    print(f"report: {out / 'report.html'}")
    print(f"diagnosis: {out / 'diagnosis.json'}")
    for what, name in _MORE.items():
        if (out / name).is_file():
            print(f"{what}: {out / name}")
    for path in more:
        print(f"file: {path}")
    return 0


def _certainty(verdict: Mapping[str, Any]) -> str:
    """Of each effect, as one may be sure while others are open; of all."""
    whole = f"{verdict['probability']:.0%}"
    each = [
        f"{row['effect']} {row['probability']:.0%}"
        for row in verdict["supported"]
    ]
    return ", ".join([*each, f"{whole} for all of it"]) if each else whole


def _PrintRemedies(effects: Sequence[str]) -> None:
    from brace_drake.effects.registry import find_effect

    for effect in effects:
        remedy = find_effect(effect).remedy
        if remedy:
            print(f"what to do about {effect}: {remedy}")


def _RunMany(args: argparse.Namespace) -> int:
    """One after the other; 2 where any failed, the others are written."""
    from brace_drake.report.summary import WriteSummary, failed_row, summary_row

    # What is wrong for all fails at once: scenario, diagram, place.
    scenario = name_scenario_option(args.scenario)
    diagram = find_diagram_option(args.diagram)
    out = HoldFolder(Path(args.out))
    rows = []
    for path, name in zip(
        args.campaigns, folder_names(args.campaigns), strict=True
    ):
        try:
            campaign = LoadCampaign(path)
            folder = MakeFolder(out / name)
            document, more = _Diagnose(
                campaign, scenario, diagram, folder, args
            )
            rows.append(summary_row(name, document))
            if not args.json:
                print(f"{name}: {document['verdict']['sentence']}")
                for file in more:
                    print(f"file: {file}")
        except BraceError as error:
            text = " ".join(str(error).split())
            rows.append(failed_row(name, text))
            print(f"brace-drake: {name}: {text}", file=sys.stderr)
        # After each, so that a long list stopped in its middle leaves one.
        WriteSummary(out, rows)
    if args.json:
        PrintJson({"campaigns": rows})
    else:
        print(f"summary: {out / 'summary.html'}")
    return 2 if any(row["error"] for row in rows) else 0


def folder_names(campaigns: Sequence[str]) -> list[str]:
    """A folder for each campaign: its own name, numbered where taken."""
    names: list[str] = []
    for path in campaigns:
        base = real_path(path).name or "campaign"
        name, count = base, 1
        while name in names:
            count += 1
            name = f"{base}_{count}"
        names.append(name)
    return names


def _Diagnose(
    campaign, scenario, diagram, out: Path, args: argparse.Namespace
) -> tuple[dict, list[Path]]:
    """Diagnoses one campaign, writes its files; returns the document, and
    which files were written for a paper.
    """
    from brace_drake.results.diagnoses import diagnose

    found = diagnose(
        campaign,
        scenario=scenario,
        diagram=diagram,
        jobs=args.jobs,
        cluster=args.cluster,
        seed=args.seed,
        command=_command(campaign, out, args),
        **choice_options(args),
    )
    found.save(out)
    more = found.export(
        out, pdf=args.pdf, figures=args.figures, tables=args.tables
    )
    return found.document, more


def _command(campaign, out: Path, args: argparse.Namespace) -> str:
    """The command that makes the diagnosis of this campaign again."""
    words = ["brace-drake", "diagnose", str(campaign.path), "--out", str(out)]
    for name in ("scenario", "diagram", "effects", "without", "free"):
        if getattr(args, name) is not None:
            words += [f"--{name}", str(getattr(args, name))]
    for name, value in args.fix or ():
        words += ["--fix", name if value is None else f"{name}={value!r}"]
    for name, (low, high) in args.bounds or ():
        words += ["--bounds", f"{name}={low!r}:{high!r}"]
    for name, (value, tolerance) in args.prior or ():
        words += ["--prior", f"{name}={value!r}:{tolerance!r}"]
    if args.seed:
        words += ["--seed", str(args.seed)]
    return shlex.join(words)


# Files that some diagnoses write beside the others.
_MORE = {
    "repaired twin": "repaired.scenario.yaml",
    "next run": "next_run.csv",
}
