"""Fits what the stated probabilities of withheld answers are worth.

    python tools/calibrate_probability.py SCORE.json [SCORE.json ...]
    python tools/calibrate_probability.py SCORE.json --check OTHER.json

Prints offset and slope of the log-odds of being right over those stated, with
standard errors, and log and Brier scores before and after: on the same cases,
and on cases that took no part.

Where the answers were given with offset a and slope b in
`gap/probability.py`, and c and d are printed: c + d a and d b replace them.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from brace_drake.withheld.calibration import fit_calibration
from brace_drake.withheld.score import proper_scores


def read(paths: list[Path]) -> tuple[np.ndarray, np.ndarray]:
    """Stated probabilities and whether the answers were right."""
    rows = [r for p in paths for r in json.loads(p.read_text())["each"]]
    told = [r for r in rows if r["probability"] is not None]
    return (
        np.array([r["probability"] for r in told], dtype=float),
        np.array([r["right"] for r in told], dtype=bool),
    )


def say(what: str, p: np.ndarray, right: np.ndarray) -> None:
    """Mean probability and scores of a set."""
    log, brier = proper_scores(p, right)
    print(
        f"{what:22} {len(p):3d} answers, told {p.mean():.3f},"
        f" right {right.mean():.3f}, log score {log:.3f}, Brier {brier:.3f}"
    )


def main() -> None:
    """Reads scores, fits, prints."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scores", nargs="+", type=Path, metavar="SCORE.json")
    parser.add_argument("--check", nargs="*", type=Path, default=[])
    args = parser.parse_args()
    told, right = read(args.scores)
    found = fit_calibration(told, right)
    errors = np.sqrt(np.diag(found.covariance))
    print(f"offset {found.offset:+.3f} (standard error {errors[0]:.3f})")
    print(f"slope  {found.slope:+.3f} (standard error {errors[1]:.3f})")
    say("as stated", told, right)
    say("calibrated", found.apply(told), right)
    if args.check:
        told, right = read(args.check)
        say("others, as stated", told, right)
        say("others, calibrated", found.apply(told), right)


if __name__ == "__main__":
    main()
