"""Reads well-formed hostile files of every format, and looks what happens.

    nice python tools/fuzz_files.py --files 100000 --seed 1 --out out/hostile

`tools/fuzz_readers.py` damages sound files; these are made from what each
format declares (`tests/hostile.py`). Batches run in processes of their own.
Status 1 where a reader ends in anything but a BraceError, takes more than 5 s,
or a process grows by more than 1 GB. Such files are kept in the folder.
"""

import argparse
import multiprocessing
import os
import resource
import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.hostile import formats, try_format

BATCH, START_S, SILENT_S, MOST_GB = 1000, 900.0, 60.0, 1.0


def memory() -> float:
    """Largest memory of the process so far, GB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def work(pipe, name: str, number: int, chosen: int) -> None:
    """Reads a batch; sends each file before its outcome."""
    before = memory()

    def told(data: bytes, problem: str) -> None:
        nonlocal before
        grown, before = memory() - before, max(before, memory())
        if not problem and grown > MOST_GB:
            problem = f"memory +{grown:.2f} GB"
        pipe.send((problem, data if problem else b""))

    sys.stderr = open(os.devnull, "w")
    try_format(name, number, chosen, told)
    pipe.send(None)


def run(name: str, number: int, chosen: int):
    """Yields problem and file of each case of a batch, in its own process."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.Process(
        target=work, args=(theirs, name, number, chosen)
    )
    process.start()
    theirs.close()
    # What compiles on first use may take its time.
    silent = START_S
    try:
        while ours.poll(silent):
            silent = SILENT_S
            case = ours.recv()
            if case is None:
                return
            yield case
        yield f"HangError: silent for {silent:g} s", b""
    except EOFError:
        process.join()
        yield f"Ended: status {process.exitcode}", b""
    finally:
        process.kill()
        process.join()


def main() -> int:
    """Runs all batches; prints counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--files", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--format", choices=formats(), help="one alone")
    parser.add_argument("--seconds", type=float, help="stop after this time")
    parser.add_argument("--out", help="folder for files that were found")
    args = parser.parse_args()
    names = [args.format] if args.format else list(formats())
    begun, read = time.monotonic(), Counter()
    found: dict[str, Counter] = {name: Counter() for name in names}
    batch = 0
    while sum(read.values()) < args.files:
        name = names[batch % len(names)]
        chosen = args.seed * 10**6 + batch
        batch += 1
        number = min(BATCH, args.files - sum(read.values()))
        for problem, data in run(name, number, chosen):
            read[name] += 1
            if problem:
                kind = problem.splitlines()[0][:100]
                found[name][kind] += 1
                if found[name][kind] == 1:
                    print(f"{name}, seed {chosen}: {problem[:300]}", flush=True)
                    if args.out:
                        folder = Path(args.out)
                        folder.mkdir(parents=True, exist_ok=True)
                        file = f"{name.replace(' ', '_')}_{chosen}"
                        (folder / file).write_bytes(data)
        if args.seconds and time.monotonic() - begun > args.seconds:
            break
    every = sum(found.values(), Counter())
    for name in names:
        print(f"{name}: {read[name]} files, {found[name].total()} findings")
    hangs = sum(n for k, n in every.items() if k.startswith("HangError"))
    large = sum(n for k, n in every.items() if k.startswith("memory"))
    print(
        f"{sum(read.values())} files in {time.monotonic() - begun:.0f} s:"
        f" {every.total() - hangs - large} tracebacks, {hangs} hangs,"
        f" {large} over {MOST_GB:g} GB"
    )
    return 1 if every else 0


if __name__ == "__main__":
    sys.exit(main())
