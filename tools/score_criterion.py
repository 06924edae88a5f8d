"""The criterion of `experiments.within_tolerances` on the stored fits.

    python tools/score_criterion.py [BANK.npz]

Decides every case of the fit bank (tools/fit_bank.py) by that criterion and
prints how many verdicts are right, by kind of case, and in how many no wrong
effect is named. Right is no gap for `none`, outside the library and no effect
for `outside`, and just the effects of the truth for `single` and `pair`.

The numbers of the criterion were chosen on these very cases: the counts are no
estimate of how often it is right on others. Held-out errors in the bank keep no
weight on the motion left out, those of the experiment a tenth.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import replace
from pathlib import Path

from fit_bank import BANK, read_bank

from brace_drake.experiments.within_tolerances.criterion import Criterion
from brace_drake.experiments.within_tolerances.decision import decide


def score(path: Path) -> tuple[Counter, Counter, Counter]:
    """Cases, right ones and those without a wrong name, by kind."""
    number, right, clean = Counter(), Counter(), Counter()
    for record, default, fits in read_bank(path):
        rows = record["fits"]
        nominal, *others = (
            replace(fit, held_out=row["held_out"])
            for fit, row in zip([default.nominal, *fits], rows, strict=True)
        )
        for fit, row in zip([nominal, *others], rows, strict=True):
            vars(fit)["is_scattered"] = row["scattered"]
        # What was left out is not known of all fits that were led to an end.
        known = [f for f in others if f.held_out is not None]
        criterion = Criterion(nominal, record["count"], record["recorded"])
        verdict, truth = decide(criterion, known), record["truth"]
        named, kind = set(verdict.effects), truth["kind"]
        number[kind] += 1
        clean[kind] += named <= set(truth["effects"])
        if kind == "none":
            right[kind] += not verdict.gap
        elif kind == "outside":
            right[kind] += verdict.outside_library and not named
        else:
            same = named == set(truth["effects"])
            right[kind] += same and not verdict.outside_library
    return number, right, clean


def main() -> None:
    """Prints the scores of a bank."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("bank", type=Path, nargs="?", default=BANK)
    number, right, clean = score(parser.parse_args().bank)
    for kind in (*sorted(number), "all"):
        counts = [
            c.total() if kind == "all" else c[kind]
            for c in (number, right, clean)
        ]
        print(
            f"{kind:8} {counts[1]:3d} of {counts[0]:3d} right,"
            f" {counts[2]:3d} without a wrong name"
        )


if __name__ == "__main__":
    main()
