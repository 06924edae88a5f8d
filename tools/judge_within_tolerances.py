"""Verdicts of campaigns on a bench known to its tolerances.

    python tools/judge_within_tolerances.py CAMPAIGN [CAMPAIGN ...]

The experiment of `brace_drake.experiments.within_tolerances`, campaign by
campaign: effects, whether something is left that the library has not, the
probability, and the time.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from brace_drake.experiments.within_tolerances.experiment import (
    judge_within_tolerances,
)
from brace_drake.recording import LoadCampaign


def main() -> None:
    """Prints a line for each campaign."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("campaigns", type=Path, nargs="+")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    for path in args.campaigns:
        start = time.monotonic()
        campaign = LoadCampaign(path)
        verdict = judge_within_tolerances(campaign, args.jobs, args.seed)
        found = " + ".join(verdict.effects)
        if verdict.outside_library:
            rest = f"{100.0 * verdict.unexplained:.0f} % is left"
            found = f"{found}, {rest}" if found else f"unknown, {rest}"
        print(
            f"{path.name}: {found or 'no gap'},"
            f" p {verdict.probability:.2f}, {time.monotonic() - start:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
