"""Kills a training run at random moments, resumes it, compares the weights.

    python tools/kill_training.py --kills 10

Two runs of the same seed: one is left alone, the other is ended by SIGKILL
and resumed until it is through. Status 1 where a weight, a bias, the scaling
or the curve differs in a single bit.
"""

import argparse
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from brace_drake.learning.policy import LoadPolicy

_TRAIN = [sys.executable, "-m", "brace_drake.cli.main", "train", "--out"]
_FILES = ("policy.npz", "best.npz")


def options(args) -> list[str]:
    """Options of the run; subjects and readings draw random numbers."""
    return [
        "--reward", "improved", "--subjects", "between", "--readings",
        "noisy", "--episodes", str(args.episodes), "--seed", str(args.seed),
    ]  # fmt: skip


def run(folder: Path, words: list[str]) -> subprocess.Popen:
    """Starts a training."""
    return subprocess.Popen(
        [*_TRAIN, str(folder), *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def finish(folder: Path, words: list[str]) -> float:
    """Runs a training to its end; seconds."""
    begun = time.monotonic()
    if run(folder, words).wait() != 0:
        raise SystemExit(f"{folder}: the training failed")
    return time.monotonic() - begun


def kill_often(folder: Path, words: list[str], moments: list[float]):
    """Kills and resumes; yields how far the run was at each kill.

    Args:
        folder: Of the run.
        words: It is started with.
        moments: In updates; the part after the comma is waited for in time.
    """
    took = 0.5
    for moment in moments:
        begun = (folder / "checkpoint.pt").exists()
        process = run(folder, ["--resume"] if begun else words)
        first, since = rows_of(folder), time.monotonic()
        # Each life gets somewhere: a kill while it loads proves little.
        goal = max(int(moment), first + 1)
        while rows_of(folder) < goal and process.poll() is None:
            time.sleep(0.02)
        done = rows_of(folder) - first
        if done > 1:
            took = (time.monotonic() - since) / done
        time.sleep((moment % 1.0) * took)
        process.send_signal(signal.SIGKILL)
        process.wait()
        yield rows_of(folder)


def rows_of(folder: Path) -> int:
    """Updates that the curve has."""
    curve = folder / "curve.csv"
    return len(curve.read_text().splitlines()) - 1 if curve.exists() else 0


def differences(one: Path, other: Path) -> list[str]:
    """What is not the same bit for bit."""
    found = []
    for name in _FILES:
        a, b = LoadPolicy(one / name), LoadPolicy(other / name)
        pairs = zip(
            (*a.weights, *a.biases, a.mean, a.gain),
            (*b.weights, *b.biases, b.mean, b.gain),
            strict=True,
        )
        if not all(np.array_equal(x, y) for x, y in pairs):
            found.append(name)
    curves = [(folder / "curve.csv").read_text() for folder in (one, other)]
    if curves[0] != curves[1]:
        found.append("curve.csv")
    return found


def main() -> int:
    """Runs, kills, compares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--episodes", type=int, default=48)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", help="default: a folder that is removed")
    args = parser.parse_args()
    random.seed(args.seed)
    with tempfile.TemporaryDirectory() as aside:
        base = Path(args.out or aside)
        whole, killed = base / "whole", base / "killed"
        seconds = finish(whole, options(args))
        print(f"uninterrupted: {rows_of(whole)} updates, {seconds:.1f} s")
        last = rows_of(whole) - 1
        moments = sorted(random.uniform(0, last) for _ in range(args.kills))
        for rows in kill_often(killed, options(args), moments):
            print(f"killed at update {rows}", flush=True)
        begun = (killed / "checkpoint.pt").exists()
        finish(killed, ["--resume"] if begun else options(args))
        different = differences(whole, killed)
    print(f"different: {', '.join(different) or 'nothing'}")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
