"""The command `brace-drake fit`: the subject's parameters from a campaign."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from brace_drake.cli.choice import AddChoice, choice_options
from brace_drake.cli.options import (
    AddCampaign,
    AddCommand,
    AddDiagram,
    AddJobs,
    AddJson,
    AddScenario,
    TellDocument,
    find_diagram_option,
    name_scenario_option,
    scenario_note,
)
from brace_drake.core.output import HoldFolder
from brace_drake.recording import LoadCampaign

_EPILOG = """\
example:
  brace-drake fit campaigns/monday --out results/monday

Prints the parameters with standard errors. --out also writes fit.json.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `fit`."""
    parser = AddCommand(
        subparsers,
        "fit",
        Run,
        help="fit the subject's parameters to the fit runs",
        description="Fits the subject's parameters to all fit runs jointly.",
        epilog=_EPILOG,
    )
    AddCampaign(parser)
    parser.add_argument("--out", metavar="DIR", help="folder for fit.json")
    parser.add_argument(
        "--solver",
        choices=("snopt", "ipopt", "nlopt"),
        default="snopt",
        help="solver of the MathematicalProgram (default: snopt)",
    )
    AddScenario(parser)
    AddDiagram(parser)
    AddChoice(parser, has_effects=False)
    AddJobs(parser)
    AddJson(parser)


def Run(args: argparse.Namespace) -> int:
    """Fits, prints a table, and writes fit.json where asked."""
    from brace_drake.results.fits import fit

    campaign = LoadCampaign(args.campaign)
    out = HoldFolder(Path(args.out)) if args.out else None
    scenario = name_scenario_option(args.scenario)
    found = fit(
        campaign,
        scenario=scenario,
        diagram=find_diagram_option(args.diagram),
        solver=args.solver,
        jobs=args.jobs,
        cluster=args.cluster,
        seed=args.seed,
        **choice_options(args),
    ).document
    TellDocument(args, found, out, "fit", format_fit)
    if not args.json:
        print(scenario_note(campaign, found["scenario"]))
    return 0


def format_fit(found: dict) -> str:
    """The starts, the parameters as a table, and how sharp the fit is."""
    from brace_drake.results.fits import fit_warnings

    lines = [
        f"start from {start['run']}: k {start['stiffness']:.0f} N/m,"
        f" c {start['damping']:.0f} N s/m"
        f" (equation (2) as printed: {start['printed_stiffness']:.0f},"
        f" {start['printed_damping']:.0f})"
        for start in found["contact_starts"]
    ]
    names = [p["name"] for p in found["parameters"]]
    width = max(map(len, names))
    lines.append(
        f"{'':{width}}  {'value':>11} {'std. error':>10} {'nominal':>10}"
    )
    for p in found["parameters"]:
        flag = "  at its limit" if p["at_limit"] else ""
        flag = "  held" if p["fixed"] else flag
        error = "unknown"
        if p["standard_error"] is not None:
            error = f"{p['standard_error']:.2g}"
        elif p["fixed"]:
            error = "-"
        lines.append(
            f"{p['name']:{width}}  {p['value']:11.5g}"
            f" {error:>10} {p['nominal']:10.5g}{flag}"
        )
    correlation = np.array(found["correlation"])
    np.fill_diagonal(correlation, 0.0)
    i, j = np.unravel_index(np.argmax(np.abs(correlation)), correlation.shape)
    condition = found["condition_number"]
    sharp = "unknown" if condition is None else f"{condition:.1f}"
    lines.append(
        f"mean square {found['mean_square']:.4f} floors,"
        f" condition {sharp}, strongest correlation"
        f" {correlation[i, j]:.2f} ({names[i]}, {names[j]}),"
        f" {found['solver']}: {found['evaluations']} evaluations"
    )
    return "\n".join([*lines, *fit_warnings(found)])
