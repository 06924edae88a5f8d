"""Lets the diagnosis answer withheld cases, and commits to its answers.

Each case is diagnosed in a process of its own that is handed a copy of the
recordings and nothing else. A case that has its diagnosis already is not run
again.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from threading import Lock

from brace_drake.core.errors import BraceError
from brace_drake.core.output import HoldFolder, WriteText
from brace_drake.core.places import real_path
from brace_drake.core.reading import LoadJson, ReadBytes, in_file
from brace_drake.withheld.judged import label
from brace_drake.withheld.schemas import ANSWER, check_shape
from brace_drake.withheld.seals import (
    SEALS,
    AnswerError,
    commit,
    digest_of,
    read_seals,
)

CASES, SECONDS = "CASES", "cpu_seconds.txt"
_RECORDINGS = ("campaign.yaml", "*.csv")


def answer_cases(
    folder: Path,
    answers: Path,
    jobs: int = 1,
    progress: Callable[[str, str], None] = lambda name, answer: None,
) -> dict:
    """Diagnoses all cases, then writes answers.json and COMMITMENT.

    Args:
        folder: Of the cases and SEALS.yaml.
        answers: Folder for the diagnoses.
        jobs: Cases at a time.
        progress: Told each case and its answer as they come.

    Returns:
        Answer by case.

    Raises:
        AnswerError: The folder holds no cases.
    """
    names = sorted(read_seals(folder))
    missing = [n for n in names if not (folder / n).is_dir()]
    if missing or not names:
        raise AnswerError(f"{folder}: no case {missing[0] if names else ''}")
    HoldFolder(answers)
    _bind(folder, answers)
    found, running = {}, _Running()
    with ThreadPoolExecutor(jobs) as pool:
        tasks = {
            pool.submit(_answer, running, folder / n, answers / n): n
            for n in names
        }
        try:
            for task in as_completed(tasks):
                found[tasks[task]] = task.result()
                progress(tasks[task], label(found[tasks[task]]["verdict"]))
        except BaseException:
            # As of a signal: what has not begun is dropped, what runs ends.
            pool.shutdown(wait=False, cancel_futures=True)
            running.stop()
            raise
    cases = {name: found[name] for name in names}
    commit(folder, answers, cases)
    return cases


def _bind(folder: Path, answers: Path) -> None:
    """Notes which cases a folder of answers is for; others are refused."""
    digest, path = digest_of(folder / SEALS), answers / CASES
    if not path.exists():
        WriteText(path, f"{digest}\n")
    elif ReadBytes(path).decode(errors="replace").strip() != digest:
        raise AnswerError(
            f"{answers}: holds answers to other cases than those of {folder};"
            " give another folder"
        )


class _Running:
    """The processes of the cases that are being diagnosed."""

    def __init__(self):
        self._lock, self._processes = Lock(), set()
        self._stopped = False

    def run(self, command: list[str], folder: str) -> tuple[int, str, float]:
        """Status, errors and CPU time, s, of a command, run in a folder."""
        with self._lock:
            if self._stopped:
                raise AnswerError("stopped")
            process = subprocess.Popen(
                command,
                cwd=folder,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
            )
            self._processes.add(process)
        with process:
            errors = process.stderr.read() if process.stderr else ""
            seconds = _wait(process)
        with self._lock:
            self._processes.discard(process)
        return process.returncode, errors, seconds

    def stop(self) -> None:
        """Ends what runs; nothing begins any more."""
        with self._lock:
            self._stopped = True
            for process in self._processes:
                process.terminate()


def _wait(process: subprocess.Popen) -> float:
    """Waits for a process; CPU time that it took, s."""
    try:
        _, status, usage = os.wait4(process.pid, 0)
    except ChildProcessError:
        # `stop` has come before and taken its status.
        process.wait()
        return 0.0
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime


def _answer(running: _Running, case: Path, out: Path) -> dict:
    """One case's verdict and closed share, of a diagnosis old or new."""
    path, error = out / "diagnosis.json", None
    try:
        error = None if path.exists() else _diagnose(running, case, out)
        document = LoadJson(path, AnswerError)
        shrink = document.get("shrink") or {}
        answer = {
            "verdict": document["verdict"],
            "closed": shrink.get("closed"),
            "seconds": _seconds(out / SECONDS),
        }
        check_shape(str(path), answer, ANSWER)
        return {**answer, "error": None}
    except (AnswerError, AttributeError, KeyError, TypeError) as problem:
        error = error or str(problem)
        return {
            "verdict": None,
            "closed": None,
            "seconds": None,
            "error": error,
        }


def _seconds(path: Path) -> float | None:
    """CPU time that was noted, if it was."""
    try:
        return float(ReadBytes(path)) if path.exists() else None
    except (BraceError, ValueError):
        return None


def _diagnose(running: _Running, case: Path, out: Path) -> str | None:
    """Runs the command on a copy of the recordings; its error, if any."""
    with tempfile.TemporaryDirectory(prefix="withheld-") as folder:
        copy = Path(folder) / case.name
        copy.mkdir()
        for pattern in _RECORDINGS:
            for file in case.glob(pattern):
                with in_file(file, AnswerError):
                    (copy / file.name).write_bytes(ReadBytes(file))
        command = [sys.executable, "-m", "brace_drake.cli.main", "diagnose"]
        command += [str(copy), "--out", str(real_path(out)), "--jobs", "1"]
        status, errors, seconds = running.run(command, folder)
    if status == 0:
        WriteText(out / SECONDS, f"{seconds:.1f}\n")
        return None
    lines = errors.strip().splitlines() or ["no message"]
    return f"status {status}: {lines[-1]}"
