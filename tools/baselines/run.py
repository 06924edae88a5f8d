"""Answers a folder of cases by the baselines.

    python tools/baselines/run.py CASES --out FOLDER [--methods sparse]

For each method FOLDER/METHOD.json holds its answers, in the format that
`brace-drake withheld score` and `withheld table` take. Cases that are answered
already are not answered again; what methods share is kept in FOLDER/kept. The
time of an answer has in it that of what is shared.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from brace_drake.core.output import WriteJson
from brace_drake.withheld.plain_answers import PLAIN_FORMAT
from tools.baselines import least_squares, residual_model, sparse
from tools.baselines.case import Case, open_case

METHODS = {
    "least_squares": least_squares.answer,
    "sparse": sparse.answer,
    "residual_model": residual_model.answer,
}


def answer_case(case: Case, method: str) -> dict:
    """A method's answer, with the CPU time that it took."""
    begin = time.process_time()
    found = METHODS[method](case)
    seconds = case.seconds + time.process_time() - begin
    return {**found, "seconds": round(seconds, 2)}


def main() -> None:
    """Answers all cases, case by case."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cases", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument(
        "--methods", nargs="+", choices=METHODS, default=list(METHODS)
    )
    parser.add_argument("--first", type=int, help="answer so many cases alone")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    paths = {method: args.out / f"{method}.json" for method in args.methods}
    told = {
        method: json.loads(path.read_text())["cases"] if path.exists() else {}
        for method, path in paths.items()
    }
    folders = sorted(p for p in args.cases.iterdir() if p.is_dir())
    for folder in folders[: args.first]:
        missing = [m for m in args.methods if folder.name not in told[m]]
        if not missing:
            continue
        case = open_case(folder, args.out / "kept")
        for method in missing:
            told[method][folder.name] = answer_case(case, method)
            document = {
                "format": PLAIN_FORMAT,
                "method": method,
                "cases": told[method],
            }
            WriteJson(paths[method], document)
        print(f"{folder.name}: {', '.join(missing)}", flush=True)


if __name__ == "__main__":
    main()
