"""The command `brace-drake diagnose`: where, which, how far."""

from __future__ import annotations

import argparse
from pathlib import Path

from tqdm import tqdm

from brace_drake.campaign import LoadCampaign
from brace_drake.cli.options import (
    AddCampaign,
    AddJobs,
    AddScenario,
    load_scenario_option,
)
from brace_drake.output import MakeFolder, WriteJson

_EPILOG = """\
example:
  brace-drake diagnose campaigns/monday --out results/monday

Writes diagnosis.json and report.html into the folder and, where effects were
found, repaired.scenario.yaml: the twin with them, for --scenario. Nothing is
estimated on runs of the validation split; they only show how far the gap
shrinks.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `diagnose`."""
    parser = subparsers.add_parser(
        "diagnose",
        help="say where the gap lies, what causes it, how far it shrinks",
        description="Diagnoses the gap between twin and recording.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    AddCampaign(parser)
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="folder for the results"
    )
    AddScenario(parser)
    AddJobs(parser)
    parser.set_defaults(run=Run)


def Run(args: argparse.Namespace) -> int:
    """Diagnoses and writes; prints the verdict and the files."""
    campaign = LoadCampaign(args.campaign)
    out = MakeFolder(Path(args.out))
    scenario = load_scenario_option(args.scenario)
    # Numba and Drake are slow to import: only once the input is good.
    from brace_drake.gap.diagnose import diagnose
    from brace_drake.gap.document import MakeDocument
    from brace_drake.gap.next_run import WriteNextRun, choose_next_run
    from brace_drake.gap.repaired import WriteRepairedScenario
    from brace_drake.gap.traces import MakeTraces
    from brace_drake.report import WriteReport

    with tqdm(total=100, unit="%", bar_format=_BAR, leave=False) as bar:

        def progress(what: str, share: float) -> None:
            bar.set_description(f"{what:<28.28}")
            bar.update(round(100 * share) - bar.n)

        found = diagnose(
            campaign, args.jobs, args.seed, scenario, progress=progress
        )
    next_run = choose_next_run(found)
    document = MakeDocument(found, next_run)
    WriteReport(document, MakeTraces(found), out / "report.html")
    repaired = WriteRepairedScenario(found, out)
    reference = WriteNextRun(next_run, out)
    WriteJson(out / "diagnosis.json", document)
    print(document["verdict"]["sentence"])
    print(f"report: {out / 'report.html'}")
    print(f"diagnosis: {out / 'diagnosis.json'}")
    if repaired is not None:
        print(f"repaired twin: {repaired}")
    if reference is not None:
        print(f"next run: {reference}, {document['next_experiment']['text']}")
    return 0


_BAR = "{desc} {bar:30} {n:3.0f} % [{elapsed}<{remaining}]"
