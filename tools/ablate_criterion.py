"""What each part of the criterion buys, on the stored fits.

    python tools/ablate_criterion.py

Decides the cases of both fit banks (tools/fit_bank.py) with one part of the
criterion left out or changed, and prints how many verdicts are right and how
many name no wrong effect. Seconds for each row. The bank within tolerances was
answered blind: no number of the criterion was chosen on it.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest import mock

sys.path.append(str(Path(__file__).resolve().parents[1]))

from brace_drake.selection import criterion, thresholds
from brace_drake.selection.criterion import Criterion
from tools.fit_bank import BANK, TOLERANCES
from tools.score_criterion import score

BANKS = {"within tolerances": TOLERANCES, "exact": BANK}


def _number(name: str, value: float) -> Any:
    """Another value of a number that decides."""
    return mock.patch.object(thresholds, name, value)


def _law(name: str, law: Any) -> Any:
    """Another law of the criterion."""
    return mock.patch.object(Criterion, name, law)


def ablations() -> Iterator[tuple[str, tuple]]:
    """Names, and what each changes."""
    yield "as it is", ()
    yield (
        "without motions left out",
        (_law("misfits", lambda s, fit: (s.misfit(fit),) * 2),),
    )
    yield "stretched tolerances cost nothing", (_number("TAIL", 0.0),)
    yield "they cost twice as much", (_number("TAIL", 2.0 * thresholds.TAIL),)
    yield (
        "they cost as much beside an unknown law",
        (_law("known", lambda s, fit: 1.0),),
    )
    yield (
        "friction that an effect contains costs nothing",
        (_law("num_effects", lambda s, fit: len(s.findings(fit))),),
    )
    yield "no noise less than thought", (_law("over", lambda s, fits: s),)
    for causes in (6, 16, 64, 181):
        yield f"{causes} causes", (_number("CAUSES", causes),)
    yield (
        "every effect leaves a quarter",
        (mock.patch.object(criterion, "cost_of", lambda n: n * math.log(4.0)),),
    )
    for name, values in (
        ("BEYOND_LEVEL", (2.0, 8.0)),
        ("MATERIAL", (0.01, 0.1, 0.3)),
        ("WITHIN", (2.0, 4.0)),
        ("TRUST", (0.002, 0.05)),
        ("TIED", (0.4, 1.4)),
    ):
        for value in values:
            yield f"{name} {value:g}", (_number(name, value),)


def main() -> None:
    """Prints the table."""
    argparse.ArgumentParser(description=__doc__.split("\n")[0]).parse_args()
    print(f"{'':48}" + "".join(f"{name:>22}" for name in BANKS))
    for name, changes in ablations():
        row = f"{name:48}"
        for bank in BANKS.values():
            with ExitStack() as stack:
                for change in changes:
                    stack.enter_context(change)
                found = score(bank)
            number = found.number.total()
            right, clean = found.right.total(), found.clean.total()
            row += f"{f'{right} of {number}, {clean}':>22}"
        print(row, flush=True)


if __name__ == "__main__":
    main()
