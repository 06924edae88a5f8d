"""The fit bank: every candidate fit of many opened blind cases.

    python tools/fit_bank.py make CASES --out FOLDER
    python tools/fit_bank.py pack FOLDER --vault VAULT.json --out BANK.npz
    python tools/fit_bank.py score [BANK.npz]
    python tools/fit_bank.py restate [BANK.npz]

`make` diagnoses cases of `brace-drake withheld make` and stores for each what
a decision needs: excess, freedom and held-out error of every fit, triangle of
its Jacobian, block tests, the null distribution, the truth. `score` decides
all of them anew, in seconds, and compares with the truth and with the verdicts
that were given when the fits were made. The bank that comes with the source is
tests/data/fit_bank.npz.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from unittest import mock

import numpy as np
from brace_drake.selection.null_bootstrap import NullDistribution

from brace_drake.effects.registry import find_effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import LeastSquaresSolution
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict, decide

BANK = Path(__file__).resolve().parents[1] / "tests/data/fit_bank.npz"
FORMAT = "brace-fit-bank/1"


def collect(case: Path, folder: Path) -> str:
    """Diagnoses a case and writes its fits; returns the case's name."""
    from brace_drake.selection.surrogate_data import loses_to_surrogates

    from brace_drake import diagnose as module
    from brace_drake.recording import LoadCampaign

    asked: dict[int, bool] = {}
    shown: set[str] = set()

    def remember_chance(evaluator, nominal, fit, seed):
        asked[id(fit)] = loses_to_surrogates(evaluator, nominal, fit, seed)
        return asked[id(fit)]

    def remember_shown(criterion, fits, is_chance, effects):
        shown.update(effects)
        return decide(criterion, fits, is_chance, effects)

    with (
        mock.patch.object(module, "loses_to_surrogates", remember_chance),
        mock.patch.object(module, "decide", remember_shown),
    ):
        d = module.diagnose(LoadCampaign(case), jobs=1, seed=0)
    arrays, rows = {}, []
    for i, fit in enumerate([d.nominal, *d.fits]):
        rows.append(_fit_row(d, fit, asked.get(id(fit))))
        arrays[f"z_{i}"], arrays[f"scales_{i}"] = fit.solution.z, fit.scales
        triangle = _triangle_of(fit)
        if triangle is not None:
            arrays[f"triangle_{i}"] = triangle.astype(np.float32)
    null = d.criterion.null
    arrays["null_misfit"], arrays["null_gain"] = null.misfit, null.gain
    record = {
        "name": case.name,
        "count": d.evaluator.count,
        "replays": d.evaluator.replays,
        "recorded": d.evaluator.recorded,
        "instruments_known": d.criterion.is_known,
        "numerical": null.numerical,
        "shown": sorted(shown),
        "fits": rows,
        "block_tests": d.block_tests,
        "verdict": _verdict_row(d.verdict),
    }
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(record, default=float)
    np.savez_compressed(folder / f"{case.name}.npz", record=text, **arrays)
    return case.name


def _fit_row(d, fit: CandidateFit, chance: bool | None) -> dict:
    from brace_drake.identification.held_out import held_out_misfit

    searched = fit.is_searched
    return {
        "effects": [e.key for e in fit.effects],
        "freedom": fit.freedom,
        "num_prior": fit.num_prior,
        "excess": fit.excess,
        "refined": fit.refined,
        "searched": searched,
        "scattered": not searched or fit.is_scattered,
        "spread": fit.spread,
        "subject": list(fit.subject),
        "values": [list(v) for v in fit.values],
        "held_out": held_out_misfit(d.evaluator, fit) if searched else None,
        "dithered": fit.is_dithered,
        "sticks": fit.sticks,
        "chance": chance,
        "is_winner": fit is d.verdict.winner,
    }


def _triangle_of(fit: CandidateFit) -> np.ndarray | None:
    from brace_drake.identification.least_squares import calc_triangle

    if not fit.is_searched:
        return None
    return calc_triangle([fit.solution.jacobian, fit.solution.residual])


def _verdict_row(verdict: Verdict) -> dict:
    return {
        "gap": verdict.gap,
        "effects": _effects(verdict),
        "outside_library": verdict.outside_library,
        "ambiguous_with": list(verdict.ambiguous_with),
        "probability": verdict.probability,
    }


def _effects(verdict: Verdict) -> list[str]:
    return [e.name for e in verdict.winner.effects] if verdict.winner else []


def pack(folder: Path, vault: Path, out: Path) -> int:
    """Writes the bank of a folder's cases with their truth; their number."""
    cases = json.loads(vault.read_text())["cases"]
    arrays, records = {}, []
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as stored:
            record = json.loads(str(stored["record"]))
            for name in stored.files:
                if name != "record":
                    arrays[f"{record['name']}_{name}"] = stored[name]
        record["truth"] = cases[record["name"]]["truth"]
        records.append(record)
    document = json.dumps({"format": FORMAT, "cases": records})
    np.savez_compressed(out, document=document, **arrays)
    return len(records)


def read_bank(
    path: Path,
) -> Iterator[tuple[dict, Criterion, list[CandidateFit]]]:
    """Record, criterion and fits of each case."""
    with np.load(path) as stored:
        for record in json.loads(str(stored["document"]))["cases"]:
            name = record["name"]
            fits = [
                _read_fit(stored, f"{name}_", i, row)
                for i, row in enumerate(record["fits"])
            ]
            null = NullDistribution(
                stored[f"{name}_null_misfit"],
                stored[f"{name}_null_gain"],
                record["numerical"],
                record["instruments_known"],
            )
            criterion = Criterion(
                fits[0],
                record["count"],
                record["instruments_known"],
                record["recorded"],
                null=null,
            )
            yield record, criterion, fits[1:]


def _read_fit(stored, prefix: str, i: int, row: dict) -> CandidateFit:
    triangle = stored.get(f"{prefix}triangle_{i}")
    jacobian, residual = None, np.zeros(0)
    if triangle is not None:
        jacobian, residual = triangle[:, :-1], triangle[:, -1]
    z = stored[f"{prefix}z_{i}"]
    fit = CandidateFit(
        effects=tuple(find_effect(key) for key in row["effects"]),
        subject=np.array(row["subject"]),
        values=tuple(np.array(v) for v in row["values"]),
        solution=LeastSquaresSolution(z, residual, jacobian, 0, True),
        scales=stored[f"{prefix}scales_{i}"],
        excess=row["excess"],
        spread=row["spread"],
        num_runs=0,
        num_prior=row["num_prior"],
        refined=row["refined"],
        sticks=row["sticks"],
        is_dithered=row["dithered"],
    )
    # Found from the whole Jacobian when the fit was made.
    vars(fit).update(is_scattered=row["scattered"], is_chance=row["chance"])
    return fit


def decide_again(record, criterion, fits) -> Verdict:
    """The verdict on stored fits."""
    shown = frozenset(record["shown"])
    return decide(criterion, fits, lambda f: bool(f.is_chance), shown)


def is_right(truth: dict, verdict: Verdict) -> bool:
    """Whether a verdict is what a perfect diagnosis says."""
    if truth["kind"] == "none":
        return not verdict.gap
    if truth["kind"] == "outside":
        return verdict.outside_library
    return sorted(_effects(verdict)) == truth["effects"]


def is_as_stored(record: dict, verdict: Verdict) -> bool:
    """Whether a verdict is the one that was given with the fits."""
    stored = record["verdict"]
    return (
        verdict.gap == stored["gap"]
        and _effects(verdict) == stored["effects"]
        and verdict.outside_library == stored["outside_library"]
        and list(verdict.ambiguous_with) == stored["ambiguous_with"]
        and bool(np.isclose(verdict.probability, stored["probability"]))
    )


def restate(path: Path) -> int:
    """Writes today's verdicts into a bank; how many have changed."""
    with np.load(path) as stored:
        document = json.loads(str(stored["document"]))
        arrays = {n: stored[n] for n in stored.files if n != "document"}
    known = {record["name"]: record for record in document["cases"]}
    changed = 0
    for record, criterion, fits in read_bank(path):
        verdict = decide_again(record, criterion, fits)
        if not is_as_stored(record, verdict):
            known[record["name"]]["verdict"] = _verdict_row(verdict)
            changed += 1
    np.savez_compressed(path, document=json.dumps(document), **arrays)
    return changed


def score(path: Path) -> None:
    """Prints how many verdicts on stored fits are right, by kind of case."""
    number, right, changed = Counter(), Counter(), []
    for record, criterion, fits in read_bank(path):
        verdict = decide_again(record, criterion, fits)
        kind = record["truth"]["kind"]
        number[kind] += 1
        right[kind] += is_right(record["truth"], verdict)
        if not is_as_stored(record, verdict):
            effects = "+".join(_effects(verdict)) or "none or outside"
            changed.append(f"{record['name']}: now {effects}")
    for kind in sorted(number):
        print(f"{kind:8} {right[kind]:3d} of {number[kind]:3d} right")
    print(f"{'all':8} {right.total():3d} of {number.total():3d} right")
    print(f"{len(changed)} verdicts differ from those given with the fits")
    print("\n".join(changed))


def main() -> None:
    """Makes, packs or scores a bank."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parts = parser.add_subparsers(dest="part", required=True)
    make = parts.add_parser("make")
    make.add_argument("cases", type=Path)
    make.add_argument("--out", type=Path, required=True)
    make.add_argument("--jobs", type=int, default=2)
    packed = parts.add_parser("pack")
    packed.add_argument("folder", type=Path)
    packed.add_argument("--vault", type=Path, required=True)
    packed.add_argument("--out", type=Path, default=BANK)
    for part in ("score", "restate"):
        known = parts.add_parser(part)
        known.add_argument("bank", type=Path, nargs="?", default=BANK)
    args = parser.parse_args()
    if args.part == "score":
        score(args.bank)
    elif args.part == "restate":
        print(f"{restate(args.bank)} verdicts have changed: {args.bank}")
    elif args.part == "pack":
        print(f"{pack(args.folder, args.vault, args.out)} cases: {args.out}")
    else:
        cases = sorted(p for p in args.cases.iterdir() if p.is_dir())
        with ProcessPoolExecutor(args.jobs) as pool:
            tasks = [pool.submit(collect, c, args.out) for c in cases]
            for task in tasks:
                print(task.result(), flush=True)


if __name__ == "__main__":
    main()
