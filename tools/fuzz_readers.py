"""Damages files of every kind that is read, and looks what the readers do.

    python tools/fuzz_readers.py --inputs 100000 --seed 1

Status 1 where a reader ends in anything but a BraceError, takes longer than
5 s, opens a file outside of the case's folder, writes, runs code, or the
process passes 1 GB beyond what it began with. A finding is made again by
`--reader NAME --only SEED`.
"""

import argparse
import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.reader_fuzz import READERS, Bench


def memory() -> float:
    """Largest memory of the process so far, GB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def main() -> int:
    """Runs all cases; prints what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--reader", help="one alone, by its name")
    parser.add_argument("--only", type=int, help="one case of it")
    args = parser.parse_args()
    readers = [r for r in READERS if args.reader in (None, r.name)]
    bad = 0
    for i, reader in enumerate(readers):
        bench, begun, before = Bench(reader), time.monotonic(), memory()
        first = args.seed * 10**9
        count = args.inputs * (i + 1) // len(readers)
        count -= args.inputs * i // len(readers)
        seeds = range(first, first + count)
        slowest, found = 0.0, {}
        for seed in seeds if args.only is None else [args.only]:
            start = time.monotonic()
            problem = bench.try_case(seed)
            slowest = max(slowest, time.monotonic() - start)
            if problem is not None:
                bad += 1
                found.setdefault(problem.split(":")[0], (seed, problem))
        bench.close()
        grown = memory() - before
        bad += grown > 1.0
        spent = time.monotonic() - begun
        print(
            f"{reader.name}: {count} inputs in {spent:.0f} s, slowest"
            f" {slowest:.2f} s, memory +{grown:.2f} GB, findings {len(found)}",
            flush=True,
        )
        for seed, problem in found.values():
            print(f"  --only {seed}: {problem[:300]}", flush=True)
    print(f"bad: {bad}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
