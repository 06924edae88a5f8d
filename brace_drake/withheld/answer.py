"""Lets the diagnosis answer withheld cases, and commits to its answers.

Each case is diagnosed in a process of its own that is handed a copy of the
recordings and nothing else. A case that has its diagnosis already is not run
again.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from datetime import UTC, datetime
from pathlib import Path

import yaml

from brace_drake.core.errors import BraceError
from brace_drake.core.output import HoldFolder, WriteJson, WriteText
from brace_drake.withheld.seals import SEALS

ANSWERS = "answers.json"
CASES = "CASES"
COMMITMENT = "COMMITMENT"
ANSWERS_FORMAT = "brace-answers/1"
_RECORDINGS = ("campaign.yaml", "*.csv")


class AnswerError(BraceError, ValueError):
    """Cases or answers are missing or unreadable."""


def read_seals(folder: Path) -> dict[str, str]:
    """Seal of each case.

    Raises:
        AnswerError: The folder holds no readable SEALS.yaml.
    """
    path = Path(folder) / SEALS
    try:
        seals = yaml.safe_load(path.read_text())["seals"]
        return {str(name): str(value) for name, value in seals.items()}
    except OSError as error:
        raise AnswerError(f"{path}: {error.strerror}") from error
    except (yaml.YAMLError, KeyError, TypeError, AttributeError) as error:
        raise AnswerError(f"{path}: holds no seals") from error


def digest_of(path: Path) -> str:
    """SHA-256 of a file's bytes.

    Raises:
        AnswerError: It cannot be read.
    """
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise AnswerError(f"{path}: {error.strerror}") from error


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
        The answers as written.

    Raises:
        AnswerError: The folder holds no cases.
    """
    names = sorted(read_seals(folder))
    missing = [n for n in names if not (Path(folder) / n).is_dir()]
    if missing or not names:
        raise AnswerError(f"{folder}: no case {missing[0] if names else ''}")
    HoldFolder(Path(answers))
    _bind(Path(folder), Path(answers))
    found = {}
    with ThreadPoolExecutor(jobs) as pool:
        tasks = {
            pool.submit(_answer, Path(folder) / n, Path(answers) / n): n
            for n in names
        }
        for task in as_completed(tasks):
            found[tasks[task]] = task.result()
            progress(tasks[task], label(found[tasks[task]]["verdict"]))
    document = {
        "format": ANSWERS_FORMAT,
        "cases": {name: found[name] for name in names},
    }
    commit(Path(folder), Path(answers), document)
    return document


def _bind(folder: Path, answers: Path) -> None:
    """Notes which cases a folder of answers is for; others are refused."""
    digest, path = digest_of(folder / SEALS), answers / CASES
    if not path.exists():
        WriteText(path, f"{digest}\n")
    elif path.read_text().strip() != digest:
        raise AnswerError(
            f"{answers}: holds answers to other cases than those of {folder};"
            " give another folder"
        )


def commit(folder: Path, answers: Path, document: dict) -> None:
    """Writes the answers and a hash that binds them to the seals.

    Hashes of answers that these replace, as a case that had failed was tried
    again, stay in the file.
    """
    path = answers / COMMITMENT
    before = yaml.safe_load(path.read_text()) if path.exists() else None
    WriteJson(answers / ANSWERS, document)
    lines: dict[str, object] = {
        "answers_sha256": digest_of(answers / ANSWERS),
        "seals_sha256": digest_of(folder / SEALS),
        "committed_at": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    if before is not None:
        if before["answers_sha256"] == lines["answers_sha256"]:
            return
        earlier = before.pop("earlier", [])
        lines["earlier"] = [*earlier, before]
    WriteText(path, yaml.safe_dump(lines, sort_keys=False))


def label(verdict: dict | None) -> str:
    """A verdict in a word: none, outside, effects joined by +, or failed."""
    if verdict is None:
        return "failed"
    if not verdict["gap"]:
        return "none"
    if verdict["outside_library"] or not verdict["effects"]:
        return "outside"
    return "+".join(sorted(verdict["effects"]))


def _answer(case: Path, out: Path) -> dict:
    """One case's verdict and closed share, of a diagnosis old or new."""
    path = out / "diagnosis.json"
    error = None if path.exists() else _diagnose(case, out)
    try:
        document = json.loads(path.read_text())
        shrink = document.get("shrink") or {}
        return {
            "verdict": document["verdict"],
            "closed": shrink.get("closed"),
            "error": None,
        }
    except (OSError, ValueError, KeyError) as problem:
        return {
            "verdict": None,
            "closed": None,
            "error": error or str(problem),
        }


def _diagnose(case: Path, out: Path) -> str | None:
    """Runs the command on a copy of the recordings; its error, if any."""
    with tempfile.TemporaryDirectory(prefix="withheld-") as folder:
        copy = Path(folder) / case.name
        copy.mkdir()
        for pattern in _RECORDINGS:
            for file in case.glob(pattern):
                shutil.copyfile(file, copy / file.name)
        command = [sys.executable, "-m", "brace_drake.cli.main", "diagnose"]
        command += [str(copy), "--out", str(out.resolve()), "--jobs", "1"]
        done = subprocess.run(
            command,
            cwd=folder,
            env=os.environ,
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode == 0:
        return None
    lines = done.stderr.strip().splitlines() or ["no message"]
    return f"status {done.returncode}: {lines[-1]}"
