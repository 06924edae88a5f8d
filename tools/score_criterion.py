"""The criterion of `selection` on the stored fits.

    python tools/score_criterion.py [BANK.npz]

Decides every case of the fit bank (tools/fit_bank.py) anew and prints how many
verdicts are right, by kind of case, in how many no wrong effect is named, and
what is said of the others. Right is no gap for `none`, outside the library and
no effect for `outside`, and just the effects of the truth for `single` and
`pair`.

The numbers of the criterion were chosen on these very cases: the counts are no
estimate of how often it is right on others. Held-out errors in the stored bank
keep no weight on the motion left out, those of a diagnosis a tenth.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from brace_drake.selection.decision import Verdict, decide

sys.path.append(str(Path(__file__).resolve().parents[1]))

from tools.fit_bank import BANK, read_bank


@dataclass
class Score:
    """Verdicts on a bank, by kind of case.

    Attributes:
        number: Of cases.
        right: Of verdicts that a perfect diagnosis would give.
        clean: Of verdicts that name no effect that is not there.
        wrong: What is said of each case that is not right.
    """

    number: Counter = field(default_factory=Counter)
    right: Counter = field(default_factory=Counter)
    clean: Counter = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)


def is_right(truth: dict, verdict: Verdict) -> bool:
    """Whether a verdict is what a perfect diagnosis says."""
    if truth["kind"] == "none":
        return not verdict.gap
    if truth["kind"] == "outside":
        return verdict.outside_library and not verdict.effects
    named = sorted(verdict.effects) == sorted(truth["effects"])
    return named and not verdict.outside_library


def score(path: Path) -> Score:
    """Decides all cases of a bank anew."""
    found = Score()
    for record, criterion, fits in read_bank(path):
        verdict, truth = decide(criterion, fits), record["truth"]
        kind = truth["kind"]
        found.number[kind] += 1
        found.clean[kind] += set(verdict.effects) <= set(truth["effects"])
        if is_right(truth, verdict):
            found.right[kind] += 1
            continue
        said = "+".join(verdict.effects) or "no effect"
        said += " and outside" if verdict.outside_library else ""
        is_so = "+".join(truth["effects"]) or kind
        found.wrong.append(f"{record['name']}: {said}; it is {is_so}")
    return found


def main() -> None:
    """Prints the score of a bank."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("bank", type=Path, nargs="?", default=BANK)
    found = score(parser.parse_args().bank)
    for kind in (*sorted(found.number), "all"):
        right, number, clean = (
            c.total() if kind == "all" else c[kind]
            for c in (found.right, found.number, found.clean)
        )
        print(
            f"{kind:8} {right:3d} of {number:3d} right,"
            f" {clean:3d} without a wrong name"
        )
    for line in found.wrong:
        print(f"  {line}")


if __name__ == "__main__":
    main()
