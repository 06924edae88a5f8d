"""Laws found for effects that the library has not, beside what was put in.

    python tools/foreign_laws.py [--kinds screw_cogging soft_stop] [--seed 77]

One bench of each foreign kind, recorded by the independent simulator of
`brace_drake.withheld`; laws of all blocks are tried, and the effects of the
library are not. About two minutes a kind.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from brace_drake.core.parallel import Workers
from brace_drake.devices.device import MakeDevice
from brace_drake.discrepancy import LawSearch, find_law
from brace_drake.document.law_rows import law_row
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording import Campaign, LoadCampaign, WriteCampaign
from brace_drake.selection.level import make_criterion
from brace_drake.validation.shrinkage import compare_new_runs
from brace_drake.withheld.cases import build_case
from brace_drake.withheld.faults import OUTSIDE, SEVERITIES
from brace_drake.withheld.make import largest_command, record_campaign
from brace_drake.withheld.simulator import make_motions


def record(fault, severity: str, seed: int, tolerances: float):
    """A campaign of one foreign effect, and what was put in."""
    rng = np.random.default_rng([seed, OUTSIDE.index(fault)])
    motions = make_motions(rng)
    largest = largest_command(motions)
    case = build_case(rng, "outside", (fault,), severity, largest, tolerances)
    campaign = record_campaign(case, motions, fault.name, rng)
    return campaign, case.changes[fault.name]


def law_of(campaign: Campaign, workers) -> dict | None:
    """The law of what no effect explains."""
    device = MakeDevice(campaign)
    twin, rate = device.twin, campaign.rate_hz
    usual = np.array([p.nominal for p in twin.subject])
    floors, _ = estimate_floors(twin, campaign, usual, 0)

    def over(split, seed):
        runs = prepare_runs(twin, campaign.split(split), floors, rate, seed)
        return Evaluator(twin, runs, workers)

    fitted, held_back = over("fit", 0), over("validation", 1000)
    nuisances = device.tolerances()
    nominal = fit_nominal(fitted, nuisances, device.uses_off)
    criterion = make_criterion(fitted, nominal, nuisances)
    compared = compare_new_runs(held_back, nominal, None)
    laws = LawSearch(fitted)
    found = find_law(device, laws, held_back, criterion, nominal, compared, 0)
    return law_row(found)


def main() -> None:
    """Prints a paragraph for each kind."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    known = {f.name: f for f in OUTSIDE}
    parser.add_argument("--kinds", nargs="*", choices=known, default=[*known])
    parser.add_argument("--severity", choices=SEVERITIES, default="medium")
    parser.add_argument("--seed", type=int, default=77)
    parser.add_argument("--tolerances", type=float, default=0.0)
    parser.add_argument("--out", type=Path, default=Path("out/foreign"))
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    with Workers(args.jobs) as workers:
        for name in args.kinds:
            made, truth = record(
                known[name], args.severity, args.seed, args.tolerances
            )
            # As a user has it: read from files.
            WriteCampaign(made, args.out / name)
            campaign = LoadCampaign(args.out / name)
            start = time.monotonic()
            law = law_of(campaign, workers)
            print(f"{name}: {truth}")
            if law is None:
                print("  no law", end="")
            else:
                print(f"  {law['text']}; closes {law['closed']:.3f}", end="")
            print(f" ({time.monotonic() - start:.0f} s)", flush=True)


if __name__ == "__main__":
    main()
