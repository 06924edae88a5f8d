"""The command `brace-drake validate`: the paper's Figures 5 to 7."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import (
    AddCampaign,
    AddCommand,
    AddJobs,
    AddScenario,
    name_scenario_option,
)
from brace_drake.core.errors import CampaignError, ReadError, quoted
from brace_drake.core.output import HoldFolder
from brace_drake.core.reading import ReadBytes, in_file, parse_json
from brace_drake.recording.fields import HUGE, TEXT, number_from, take

_EPILOG = """\
example:
  brace-drake validate campaigns/monday --out out/monday

Writes
  replay.png       the twin on the recorded reference, beside ring and torso
  regression.png   the paper's network on the measured force, and its error
  force.png        twin and measured force before and after the fit, on a fit
                   run and on a validation run
  validation.json  their numbers
"""

_PARAMETER = {
    "name": TEXT._replace(required=True),
    "value": number_from(-HUGE, HUGE),
}


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `validate`."""
    parser = AddCommand(
        subparsers,
        "validate",
        Run,
        help="draw the twin beside the recording, before and after the fit",
        description="Replays a campaign of the bench, as the paper validates.",
        epilog=_EPILOG,
    )
    AddCampaign(
        parser,
        nargs="?",
        help="folder with campaign.yaml (default: the recorded example)",
    )
    parser.add_argument(
        "--out",
        default="out/validate",
        metavar="DIR",
        help="folder for the figures (default: out/validate)",
    )
    parser.add_argument(
        "--fit",
        metavar="FILE",
        help="fit.json of this campaign (default: it is fitted now)",
    )
    parser.add_argument(
        "--show", metavar="NAME", help="fit run to show (default: the first)"
    )
    AddScenario(parser)
    AddJobs(parser)


def Run(args: argparse.Namespace) -> int:
    """Fits where needed, draws, and prints the errors."""
    from brace_drake.core.resources import example_campaign_path
    from brace_drake.experiments.validate import choose_run, validate_twin
    from brace_drake.experiments.validation_figures import WriteValidation
    from brace_drake.recording import LoadCampaign

    path = args.campaign or example_campaign_path()
    if not args.campaign and not path.is_dir():
        raise CampaignError(
            "name a campaign: the recorded example comes with the source alone"
        )
    campaign = LoadCampaign(path)
    choose_run(campaign, args.show)
    scenario = name_scenario_option(args.scenario)
    given = _load_fit(args.fit) if args.fit else None
    out = HoldFolder(Path(args.out))
    found = given or _fit(campaign, scenario, args)
    shown = validate_twin(campaign, found, scenario, args.show)
    document = WriteValidation(out, shown)
    network = document["regression"]
    print(
        f"network on {network['run']}: k {network['stiffness_N_m']:.0f} N/m,"
        f" c {network['damping_N_s_m']:.0f} N s/m,"
        f" RMSE {network['rmse_N']:.3f} N"
    )
    for split, run in document["runs"].items():
        print(
            f"force, {run['file']} ({split}): RMSE"
            f" {run['force_rmse_N_before']:.3f} N before,"
            f" {run['force_rmse_N_after']:.3f} N after the fit"
        )
    print(f"figures: {out}")
    return 0


def _fit(campaign, scenario, args) -> dict:
    from brace_drake.results import fits

    options = {"jobs": args.jobs, "cluster": args.cluster, "seed": args.seed}
    return fits.fit(campaign, scenario=scenario, **options).document


def _load_fit(path: str) -> dict:
    from brace_drake.identification.subject.campaign_fit import FORMAT

    with in_file(path, CampaignError):
        data = ReadBytes(path, 16)
    try:
        found = parse_json(data)
    except ReadError:
        found = None
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise CampaignError(
            f"{path}: is not a fit.json of `brace-drake fit --out`"
        )
    values = found.get("parameters")
    for value in values if isinstance(values, list) else [values]:
        if not isinstance(value, dict) or take(value, _PARAMETER)[1]:
            raise CampaignError(
                f"{path}: a parameter is {quoted(value)}; allowed: name and"
                " value"
            )
    if take(found, {"campaign": TEXT})[1] or "campaign" not in found:
        raise CampaignError(f"{path}: campaign is not a name")
    return found
