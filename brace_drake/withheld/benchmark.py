"""Frozen sets of cases: made by seed on any machine, known by their checksum.

A set is a file in `sets`: how many cases, their seed, the multiple of the
tolerances, and what was recorded when it was frozen. `sha256` is over all CSV
files, byte by byte. Processors differ in the last digit of a sine, and a
reading that such a digit rounds the other way goes through the control loop: so
where the bytes differ `rms` decides, the root mean square of each column over
the runs of a case. Other noise or another subject move one of them by more than
`SAME`, last digits do not.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brace_drake.core.errors import BraceError, suggest
from brace_drake.core.reading import LoadYaml, ReadBytes, in_file
from brace_drake.withheld.seals import AnswerError, read_seals

SET_FORMAT = "brace-benchmark-set/1"
SETS = Path(__file__).parent / "sets"
# Relative difference of a column's root mean square between two machines.
SAME = 1e-4


class BenchmarkError(BraceError, ValueError):
    """There is no such set, or what was made is not it."""


@dataclass(frozen=True)
class FrozenSet:
    """A set as it was frozen.

    Attributes:
        name: By which it is asked for.
        title: What it holds, in a few words.
        cases, seed, tolerances: What `make_cases` takes.
        sha256: Over the recordings.
        rms: By case, the root mean square of each column.
    """

    name: str
    title: str
    cases: int
    seed: int
    tolerances: float
    sha256: str
    rms: dict[str, list[float]]


def set_names() -> list[str]:
    """All sets that there are."""
    return sorted(path.stem for path in SETS.glob("*.yaml"))


def find_set(name: str) -> FrozenSet:
    """The set of a name.

    Raises:
        BenchmarkError: There is none.
    """
    names = set_names()
    if name not in names:
        raise BenchmarkError(
            f"no benchmark {name!r}{suggest(name, names)}; there are"
            f" {', '.join(names)}"
        )
    document = LoadYaml(SETS / f"{name}.yaml", BenchmarkError)
    if document.pop("format", None) != SET_FORMAT:
        raise BenchmarkError(f"{SETS / name}.yaml: not a {SET_FORMAT} document")
    return FrozenSet(name, **document)


def check_set(folder: Path, wanted: FrozenSet) -> str:
    """Compares recordings with a frozen set.

    Returns:
        How exactly they are the same, in words.

    Raises:
        BenchmarkError: They are others.
        AnswerError: A recording is missing.
    """
    if digest_of_recordings(folder) == wanted.sha256:
        return "the recordings of the set, to the last digit"
    found = rms_of_recordings(folder)
    if set(found) != set(wanted.rms):
        raise BenchmarkError(
            f"{folder}: {len(found)} cases, the set {wanted.name} has"
            f" {len(wanted.rms)}"
        )
    worst, where = max(
        (_difference(found[name], wanted.rms[name]), name) for name in found
    )
    if worst > SAME:
        raise BenchmarkError(
            f"{folder}/{where}: not as the set {wanted.name} was frozen: the"
            f" root mean square of a column differs by {worst:.1e}, allowed"
            f" {SAME:.0e}"
        )
    return (
        "the recordings of the set but for last digits: root mean squares"
        f" differ by {worst:.0e} at most"
    )


def digest_of_recordings(folder: Path) -> str:
    """SHA-256 over names and bytes of all CSV files, in order."""
    digest = hashlib.sha256()
    for path in _recordings(folder):
        digest.update(f"{path.parent.name}/{path.name}\n".encode())
        with in_file(path, AnswerError):
            digest.update(ReadBytes(path))
    return digest.hexdigest()


def rms_of_recordings(folder: Path) -> dict[str, list[float]]:
    """By case, root mean square of each column over all its runs."""
    tables: dict[str, list[np.ndarray]] = {}
    for path in _recordings(folder):
        with in_file(path, AnswerError):
            lines = ReadBytes(path).decode(errors="replace").splitlines()
        try:
            table = np.loadtxt(lines, delimiter=",", skiprows=1, ndmin=2)
        except ValueError as problem:
            raise AnswerError(f"{path}: {problem}") from problem
        tables.setdefault(path.parent.name, []).append(table)
    return {
        name: [float(f"{x:.7g}") for x in _rms(np.concatenate(parts))]
        for name, parts in tables.items()
    }


def _rms(table: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(table**2, axis=0))


def _difference(found: list[float], wanted: list[float]) -> float:
    """Largest relative difference of two cases' columns."""
    if len(found) != len(wanted):
        return np.inf
    a, b = np.array(found), np.array(wanted)
    return float(np.max(np.abs(a - b) / np.maximum(np.abs(b), 1e-12)))


def _recordings(folder: Path) -> list[Path]:
    names = sorted(read_seals(folder))
    files = [p for n in names for p in sorted((folder / n).glob("*.csv"))]
    if not files:
        raise AnswerError(f"{folder}: no recordings")
    return files
