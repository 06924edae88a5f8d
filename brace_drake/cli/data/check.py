"""The command `brace-drake check`: is a campaign fit for use?"""

from __future__ import annotations

import argparse
from dataclasses import asdict

from brace_drake.cli.options import (
    AddCampaign,
    AddCommand,
    AddJson,
    AddScenario,
    PrintJson,
    name_scenario_option,
    scenario_note,
)
from brace_drake.core.errors import BraceError
from brace_drake.recording import DEVICES, Campaign, ExamineCampaign
from brace_drake.recording.findings import Problem, by_message, counted, error

_EPILOG = """\
example:
  brace-drake check campaigns/monday

Prints one line per problem. Checks the files, checks by the device's own laws
that the channels agree, for example that commands follow from readings, and
tells what would keep `fit` and `diagnose` from beginning.
Ends with status 2 if there is an error, else with 0; warnings are allowed.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `check` to the command line."""
    parser = AddCommand(
        subparsers,
        "check",
        Run,
        help="find every problem of a recorded campaign",
        description="Finds every problem of a recorded campaign.",
        epilog=_EPILOG,
    )
    AddCampaign(parser)
    AddScenario(parser)
    AddJson(parser)


def Run(args: argparse.Namespace) -> int:
    """Prints the problems and a summary; 2 when there are errors, else 0."""
    scenario, note = name_scenario_option(args.scenario), ""
    campaign, problems = ExamineCampaign(args.campaign)
    if campaign is not None:
        problems, note = _WithRecordingFaults(problems, campaign, scenario)
    errors = sum(problem.severity == "error" for problem in problems)
    warnings = len(problems) - errors
    if args.json:
        usable = not errors
        rows = [asdict(problem) for problem in problems]
        PrintJson({"usable": usable, "problems": rows})
        return 2 if errors else 0
    for line in by_message(problems):
        print(line)
    if note:
        print(note)
    verdict = "not usable" if errors else "usable"
    print(
        f"{args.campaign}: {verdict}, {counted(errors, 'error')}, "
        f"{counted(warnings, 'warning')}"
    )
    return 2 if errors else 0


def _WithRecordingFaults(
    problems: list[Problem], campaign: Campaign, scenario
) -> tuple[list[Problem], str]:
    """Problems with the faults of the recording behind them, and with what no
    twin can be made of; and which scenario was used, empty where nobody has
    named one.
    """
    # Numba and Drake are slow to import: only once the files are good.
    from brace_drake.devices.device import MakeDevice
    from brace_drake.devices.nominal_scenario import choose_scenario
    from brace_drake.recording_faults import check_recording

    named = choose_scenario(campaign, scenario)
    refused, device = [], None
    try:
        device = MakeDevice(campaign, named)
    except BraceError as e:
        if named.scenario is not None:
            raise
        # Of a diagram nobody has said what makes it. The files of others can
        # still be asked.
        if not DEVICES[campaign.device].has_ports:
            reason = str(e).removeprefix(f"{campaign.path}: ")
            refused = [error(str(campaign.path), reason)]
    found = [
        problem
        for finding in check_recording(campaign, device)
        for problem in finding.problems()
    ]
    # A fault with a name stands for what was suspected of the same column.
    told = {(p.file, p.column) for p in found if p.column is not None}
    kept = [p for p in problems if (p.file, p.column) not in told]
    note = ""
    if named.file is not None:
        note = scenario_note(campaign, named.describe(named.scenario))
    return kept + found + refused, note
