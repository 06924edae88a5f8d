"""The fit bank: every candidate fit of many opened blind cases.

    python tools/fit_bank.py make CASES --out FOLDER [--answers FOLDER]
    python tools/fit_bank.py pack FOLDER --vault VAULT.json --out BANK.npz

`make` diagnoses cases of `brace-drake withheld make` and stores for each what
a decision needs: of the case the number of values and the level, of every fit
its effects, what it leaves on the runs that it was fitted to and on motions
left out, how far it stretches tolerances and which effects are within theirs.
With `--answers` the diagnoses themselves are kept beside, as `brace-drake
withheld answer` writes them: a blind set is answered and banked in one go.
`pack` puts them into one file, with the truth. tools/score_criterion.py decides
all of them anew, in seconds, and counts which verdicts are right.

Two banks come with the source, in tests/data. fit_bank.npz is of machines that
are exactly as their scenario says: nothing is within tolerances there, no
tolerance is stretched, and the level is that of the noise.
fit_bank_tolerances.npz is of a blind set of machines off within tolerances.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import LeastSquaresSolution
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.tolerated import is_within
from brace_drake.withheld.answer import SECONDS

_DATA = Path(__file__).resolve().parents[1] / "tests/data"
BANK, TOLERANCES = (
    _DATA / f"{name}.npz" for name in ("fit_bank", "fit_bank_tolerances")
)
FORMAT = "brace-fit-bank/1"


@dataclass(frozen=True)
class StoredFit(CandidateFit):
    """A fit without its residuals.

    Attributes:
        known_within: Which of its effects are within tolerances.
    """

    known_within: tuple[bool, ...] = ()


class StoredCriterion(Criterion):
    """The criterion of stored fits, which know what is within tolerances."""

    def findings(self, fit: CandidateFit) -> list[Effect]:
        """A fit's effects that are not within tolerances."""
        assert isinstance(fit, StoredFit)
        pairs = zip(fit.effects, fit.known_within, strict=True)
        return [effect for effect, within in pairs if not within]


def collect(case: Path, folder: Path, answers: Path | None) -> str:
    """Diagnoses a case and writes its fits; returns the case's name."""
    from brace_drake.recording import LoadCampaign
    from brace_drake.results.diagnoses import diagnose

    began = time.process_time()
    result = diagnose(LoadCampaign(case), jobs=1, seed=0)
    if answers is not None:
        result.save(answers / case.name)
        seconds = time.process_time() - began
        (answers / case.name / SECONDS).write_text(f"{seconds:.1f}\n")
    d = result.found
    record = {
        "name": case.name,
        "count": d.criterion.count,
        "recorded": d.criterion.recorded,
        "level": d.criterion.level,
        "chance": d.criterion.chance,
        "replays": d.evaluator.replays,
        "fits": [_fit_row(d, fit) for fit in (d.criterion.nominal, *d.fits)],
        "verdict": {
            "gap": d.verdict.gap,
            "effects": list(d.verdict.effects),
            "outside_library": d.verdict.outside_library,
            "ambiguous_with": list(d.verdict.ambiguous_with),
            "probability": d.verdict.probability,
        },
    }
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(record, default=float)
    (folder / f"{case.name}.json").write_text(text)
    return case.name


def _fit_row(d, fit: CandidateFit) -> dict:
    searched = fit.is_searched
    return {
        "effects": [e.key for e in fit.effects],
        "values": [list(v) for v in fit.values],
        "subject": list(fit.subject),
        "spread": fit.spread,
        "excess": fit.excess,
        "held_out": fit.held_out,
        "stretch": fit.stretch,
        "within": [is_within(u, fit.spread, d.nuisances) for u in fit.uses],
        "refined": fit.refined,
        "searched": searched,
        "scattered": not searched or fit.is_scattered,
        "dithered": fit.is_dithered,
    }


def pack(folder: Path, vault: Path, out: Path) -> int:
    """Writes the bank of a folder's cases with their truth; their number."""
    cases = json.loads(vault.read_text())["cases"]
    records = []
    for path in sorted(folder.glob("*.json")):
        record = json.loads(path.read_text())
        record["truth"] = cases[record["name"]]["truth"]
        records.append(record)
    document = json.dumps({"format": FORMAT, "cases": records})
    np.savez_compressed(out, document=document)
    return len(records)


def read_bank(path: Path) -> Iterator[tuple[dict, Criterion, list[StoredFit]]]:
    """Record, criterion and fits of each case."""
    with np.load(path) as stored:
        document = json.loads(str(stored["document"]))
    for record in document["cases"]:
        nominal, *fits = (_read_fit(row) for row in record["fits"])
        criterion = StoredCriterion(
            nominal,
            record["count"],
            record["recorded"],
            record.get("level", thresholds.LEVEL),
            record.get("chance", 0.0),
            is_last=True,
        )
        yield record, criterion.over([nominal, *fits]), fits


def _read_fit(row: dict) -> StoredFit:
    subject = np.array(row["subject"])
    jacobian = np.zeros((0, len(subject))) if row["searched"] else None
    fit = StoredFit(
        effects=tuple(find_effect(key) for key in row["effects"]),
        subject=subject,
        values=tuple(np.array(v) for v in row["values"]),
        solution=LeastSquaresSolution(subject, np.zeros(0), jacobian, 0, True),
        scales=np.ones(len(subject)),
        excess=row["excess"],
        spread=row["spread"],
        num_runs=0,
        refined=row["refined"],
        is_dithered=row["dithered"],
        held_out=row["held_out"],
        stretch=row.get("stretch", 0.0),
        known_within=tuple(row.get("within", [False] * len(row["effects"]))),
    )
    # Found from the whole Jacobian when the fit was made.
    vars(fit)["is_scattered"] = row["scattered"]
    return fit


def main() -> None:
    """Makes or packs a bank."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parts = parser.add_subparsers(dest="part", required=True)
    make = parts.add_parser("make")
    make.add_argument("cases", type=Path)
    make.add_argument("--out", type=Path, required=True)
    make.add_argument("--answers", type=Path)
    make.add_argument("--jobs", type=int, default=2)
    packed = parts.add_parser("pack")
    packed.add_argument("folder", type=Path)
    packed.add_argument("--vault", type=Path, required=True)
    packed.add_argument("--out", type=Path, default=BANK)
    args = parser.parse_args()
    if args.part == "pack":
        print(f"{pack(args.folder, args.vault, args.out)} cases: {args.out}")
    else:
        cases = sorted(p for p in args.cases.iterdir() if p.is_dir())
        done = {p.stem for p in args.out.glob("*.json")}
        # A process for each case: memory and CPU time are its own.
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(
            args.jobs, context, max_tasks_per_child=1
        ) as pool:
            tasks = [
                pool.submit(collect, c, args.out, args.answers)
                for c in cases
                if c.name not in done
            ]
            for task in tasks:
                print(task.result(), flush=True)


if __name__ == "__main__":
    main()
