"""Runs the suite in few processes, the longest test files first.

    python tools/run_tests.py [tests.test_import ...] [--processes 2]
        [--also CMD]

Without names all of tests/ is run. Processes take one file after the other.
The first files compile what the others use, so that no two processes compile
the same; commands that are to be run also run beside them. Files of the link
keep real time: they have a process of their own beside the others, which give
way to it. Prints a line for each file, what failed, and in the end how many
tests passed and failed; status 1 where one failed, or a command.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import subprocess
import sys
import time
import unittest
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
# How long each file took when it was last run here, s.
TIMES = ROOT / "out" / "test_times.json"
# What the single tests of a second and more took, s, the slowest first.
SLOW = ROOT / "out" / "slow_tests.json"
REAL_TIME = "tests.test_link_"
# They compile nearly all laws, each in its own way.
FIRST = ("tests.test_lanes", "tests.test_transfer")
# Where nothing was timed yet: the longest of all.
LONG = (
    "diagnose",
    "notebooks",
    "leads_back",
    "documentation",
    "diagram",
    "axis",
    "parallel",
    "pad_diagnosis",
    "disk",
    "within_tolerances",
    "station_safety",
    "report",
    "plan",
    "axis_follower",
    "recording_faults",
)
# Niceness of what gives way to the link. Beside other jobs of the machine it
# gets half of what each of them gets (at 10 it would be a tenth).
NICENESS = 3
# A process ends after so many files, and with it what they left in memory.
FILES_PER_PROCESS = 15


class Outcome(NamedTuple):
    """What a file's tests came to."""

    name: str
    passed: int
    failed: tuple[str, ...]
    skipped: int
    seconds: float
    report: str
    slow: dict[str, float]


class _Result(unittest.TextTestResult):
    """Counts what has passed, and times it; a test is slow from 1 s on."""

    passed = 0

    def __init__(self, *args):
        super().__init__(*args)
        self.slow: dict[str, float] = {}

    def startTest(self, test):
        super().startTest(test)
        self._start = time.monotonic()

    def stopTest(self, test):
        super().stopTest(test)
        seconds = round(time.monotonic() - self._start, 1)
        if seconds >= 1.0:
            self.slow[test.id()] = seconds

    def addSuccess(self, test):
        super().addSuccess(test)
        self.passed += 1


def run_file(name: str) -> Outcome:
    """Runs the tests of a module, with what they print kept back."""
    start, text = time.monotonic(), io.StringIO()
    suite = unittest.defaultTestLoader.loadTestsFromName(name)
    runner = unittest.TextTestRunner(text, buffer=True, resultclass=_Result)
    result = runner.run(suite)
    # Parts of a test fail with it, as one.
    bad = [
        getattr(test, "test_case", test).id()
        for test, _ in (*result.failures, *result.errors)
    ]
    bad += [test.id() for test in result.unexpectedSuccesses]
    failed = tuple(dict.fromkeys(bad))
    passed = result.passed + len(result.expectedFailures)
    seconds = time.monotonic() - start
    report = text.getvalue() if failed else ""
    return Outcome(
        name,
        passed,
        failed,
        len(result.skipped),
        seconds,
        report,
        result.slow,
    )


def _dead(name: str, why: str, seconds: float = 0.0) -> Outcome:
    return Outcome(name, 0, (name,), 0, seconds, why, {})


def longest_first(names: list[str]) -> list[str]:
    """Names by how long they took; by a guess where that is not known."""
    try:
        times = json.loads(TIMES.read_text())
    except (OSError, ValueError):
        times = {}
    guess = {f"tests.test_{name}": 1e3 - i for i, name in enumerate(LONG)}
    return sorted(names, key=lambda n: -times.get(n, guess.get(n, 5.0)))


class Process:
    """A process of its own that runs one file after the other.

    Names and outcomes go through pipes of their own: what tests and their
    children write or read elsewhere does not disturb them.
    """

    def __init__(self, niceness: int):
        ask, self._names = os.pipe()
        self._outcomes, answer = os.pipe()
        command = [sys.executable, __file__, "--serve", str(ask), str(answer)]
        self._process = subprocess.Popen(
            [*command, "--niceness", str(niceness)],
            stdin=subprocess.DEVNULL,
            pass_fds=(ask, answer),
        )
        os.close(ask)
        os.close(answer)
        self._answers = os.fdopen(self._outcomes, "r")

    def run(self, name: str) -> Outcome:
        """Runs a file; a process that dies meanwhile fails it."""
        with contextlib.suppress(BrokenPipeError):
            os.write(self._names, f"{name}\n".encode())
            line = self._answers.readline()
            if line:
                values = json.loads(line)
                values["failed"] = tuple(values["failed"])
                return Outcome(**values)
        why = f"the process ended with status {self._process.wait()}\n"
        return _dead(name, why)

    def close(self) -> None:
        """Ends the process, whatever its threads still do."""
        os.close(self._names)
        self._answers.close()
        self._process.kill()
        self._process.wait()


def serve(ask: int, answer: int, niceness: int) -> int:
    """Runs files as their names come; the loop of a `Process`."""
    os.nice(niceness)
    # Children of tests must not hold the pipes open.
    os.set_inheritable(ask, False)
    os.set_inheritable(answer, False)
    with os.fdopen(ask, "r") as names, os.fdopen(answer, "w") as outcomes:
        for name in names:
            try:
                found = run_file(name.strip())
            except Exception as error:
                why = f"{type(error).__name__}: {error}\n"
                found = _dead(name.strip(), why)
            outcomes.write(json.dumps(found._asdict()) + "\n")
            outcomes.flush()
    return 0


def run_line(names: deque[str], niceness: int) -> list[Outcome]:
    """Takes one file after the other until there are none, in processes of
    which one runs at a time; prints a line for each file.
    """
    outcomes: list[Outcome] = []
    process = Process(niceness)
    while True:
        try:
            name = names.popleft()
        except IndexError:
            break
        found = process.run(name)
        outcomes.append(found)
        if not found.seconds or len(outcomes) % FILES_PER_PROCESS == 0:
            process.close()
            process = Process(niceness)
        line = (
            f"{found.seconds:7.1f} s  {name}: {found.passed} passed,"
            f" {len(found.failed)} failed, {found.skipped} skipped\n"
        )
        print(line + found.report, end="", flush=True)
    process.close()
    return outcomes


def run_command(command: str) -> Outcome:
    """Runs a command of the shell, which fails as a test does."""
    start = time.monotonic()
    done = subprocess.run(
        command, shell=True, text=True, capture_output=True, cwd=ROOT
    )
    seconds = time.monotonic() - start
    print(f"{seconds:7.1f} s  {command}: status {done.returncode}", flush=True)
    found = _dead(command, done.stdout + done.stderr, seconds)
    if not done.returncode:
        return found._replace(failed=(), report="")
    print(found.report, end="", flush=True)
    return found


def run_all(
    names: list[str], processes: int, commands: list[str]
) -> list[Outcome]:
    """Runs all files, those of the link in a line of their own, and commands
    beside the first.
    """
    ordered = longest_first(names)
    first = deque(name for name in FIRST if name in names)
    beside = deque(name for name in ordered if name.startswith(REAL_TIME))
    others = deque(n for n in ordered if n not in beside and n not in first)
    with ThreadPoolExecutor(2 + processes) as threads:
        told = threads.submit(lambda: [run_command(c) for c in commands])
        outcomes = run_line(first, NICENESS) if first else []
        lines = [threads.submit(run_line, beside, 0)]
        lines += [
            threads.submit(run_line, others, NICENESS)
            for _ in range(processes - 1)
        ]
        # One process gives its place to the commands.
        outcomes += told.result()
        lines.append(threads.submit(run_line, others, NICENESS))
        for line in lines:
            outcomes += line.result()
    return outcomes


def main() -> int:
    """Returns 0 where every test passed, else 1."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", metavar="tests.test_NAME")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    parser.add_argument(
        "--also", action="append", default=[], metavar="COMMAND"
    )
    parser.add_argument("--serve", type=int, nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--niceness", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    # Before any library of linear algebra starts threads of its own.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.path.insert(0, str(ROOT))
    if args.serve:
        return serve(*args.serve, args.niceness)
    files = sorted((ROOT / "tests").glob("test_*.py"))
    names = args.names or [f"tests.{file.stem}" for file in files]
    start = time.monotonic()
    outcomes = run_all(names, args.processes, args.also)
    failed = [test for found in outcomes for test in found.failed]
    passed = sum(found.passed for found in outcomes)
    skipped = sum(found.skipped for found in outcomes)
    if not args.names:
        TIMES.parent.mkdir(exist_ok=True)
        times = {o.name: round(o.seconds, 1) for o in outcomes if o.passed}
        TIMES.write_text(json.dumps(times, indent=1))
        slow = {k: v for o in outcomes for k, v in o.slow.items()}
        ordered = dict(sorted(slow.items(), key=lambda item: -item[1]))
        SLOW.write_text(json.dumps(ordered, indent=1))
    for test in failed:
        print(f"failed: {test}")
    seconds = time.monotonic() - start
    print(f"{skipped} skipped, in {seconds:.0f} s")
    print(f"{passed} passed, {len(failed)} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
