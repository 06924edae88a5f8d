"""The one place where files of others are opened."""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from brace_drake.core.errors import BraceError, ReadError, quoted, reason

# Sets another bound on the size of files, MB, where it is the larger one.
MOST_MB = "BRACE_DRAKE_MOST_MB"
# An hour of a bench at 200 Hz is 110 MB.
LARGEST = 128
_MB = 1_000_000
_KINDS = (
    (stat.S_ISDIR, "is a folder"),
    (stat.S_ISFIFO, "is a pipe"),
    (stat.S_ISSOCK, "is a socket"),
    (stat.S_ISCHR, "is a device"),
    (stat.S_ISBLK, "is a device"),
)


def check_file(path: str | Path, most_mb: float = LARGEST) -> None:
    """Refuses what is no regular file, and what is too large; opens nothing.

    Raises:
        ReadError: One line, without the file's name.
    """
    _check_size(_check_kind(path).st_size, most_mb)


def _check_kind(path: str | Path) -> os.stat_result:
    try:
        status = os.stat(path)
    except (OSError, ValueError) as error:
        raise ReadError(f"cannot be read: {reason(error)}") from error
    words = kind_of(status.st_mode)
    if words:
        raise ReadError(f"cannot be read: {words}; allowed: a file")
    return status


def kind_of(mode: int) -> str:
    """What is no regular file, in words; empty of a file."""
    return next((words for is_kind, words in _KINDS if is_kind(mode)), "")


def ReadStart(path: str | Path, count: int) -> bytes:
    """The first bytes of a regular file of any size.

    Raises:
        ReadError: One line, without the file's name.
    """
    _check_kind(path)
    try:
        with open(path, "rb", buffering=0, opener=_open) as file:
            return file.read(count)
    except OSError as error:
        raise ReadError(f"cannot be read: {reason(error)}") from error


def ReadBytes(path: str | Path, most_mb: float = LARGEST) -> bytes:
    """All of a regular file; waits for nothing.

    Raises:
        ReadError: One line, without the file's name.
    """
    check_file(path, most_mb)
    most = most_bytes(most_mb)
    try:
        # Files of the system may grow, or have no more to tell for now.
        with open(path, "rb", buffering=0, opener=_open) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise ReadError("cannot be read: is no file any more")
            parts, size = [], 0
            while part := file.read(min(most + 1, 1 << 24)):
                parts.append(part)
                size += len(part)
                _check_size(size, most_mb)
    except OSError as error:
        raise ReadError(f"cannot be read: {reason(error)}") from error
    return b"".join(parts)


def _open(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)


@contextlib.contextmanager
def in_file(path: str | Path, error: type[BraceError]) -> Iterator[None]:
    """Names the file in what its reader refuses, as an error of a room."""
    try:
        yield
    except ReadError as problem:
        raise error(f"{path}: {problem}") from problem


def most_bytes(most_mb: float) -> int:
    """The bound, or that of the environment where it is larger.

    Raises:
        ReadError: That of the environment is no number.
    """
    asked = os.environ.get(MOST_MB, "")
    if not asked:
        return int(most_mb * _MB)
    try:
        # Written so that NaN fails.
        if 0.0 < float(asked) < 1e9:
            return int(max(most_mb, float(asked)) * _MB)
    except ValueError:
        pass
    raise ReadError(f"{MOST_MB} is {quoted(asked)}; allowed: a number of MB")


def _check_size(size: int, most_mb: float) -> None:
    most = most_bytes(most_mb)
    if size > most:
        raise ReadError(
            f"cannot be read: has {size / _MB:.4g} MB; allowed:"
            f" {most / _MB:g} MB, or"
            f" as much as {MOST_MB} says in the environment"
        )
