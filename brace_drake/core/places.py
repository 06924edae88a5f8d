"""Places that a user names for results: looked at before any work begins."""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path

from brace_drake.core.errors import OutputError, ReadError, reason
from brace_drake.core.reading.files import ReadStart, kind_of

# Deeper ones are a mistake, and no tool can remove them.
_MOST_PARTS = 200


def real_path(path: str | Path) -> Path:
    """A path without links, absolute; those that form a ring stay in it."""
    return Path(os.path.realpath(path))


def check_folder(path: Path) -> None:
    """Refuses a folder for results that cannot be made; makes nothing.

    Raises:
        OutputError: One line: the place, and what is in the way.
    """
    path = Path(path)
    _check_depth(path)
    place = _nearest(path)
    at = "" if place == path else f"{place} "
    try:
        status = os.stat(place)
    except FileNotFoundError as error:
        raise _refused(path, f"{at}is a link to nothing") from error
    except OSError as error:
        raise _refused(path, reason(error)) from error
    if not stat.S_ISDIR(status.st_mode):
        what = kind_of(status.st_mode) or "is a file"
        raise _refused(path, f"{at}{what}")
    _try(path, place)


def check_file(path: Path) -> None:
    """Refuses a file for results that cannot be made; makes nothing.

    Raises:
        OutputError: One line: the place, and what is in the way.
    """
    path = Path(path)
    _check_depth(path)
    _nearest(path)
    target = real_path(path)
    if os.path.islink(target):
        raise _refused(path, "links to itself")
    if os.path.exists(target) and not os.path.isfile(target):
        raise _refused(path, kind_of(os.stat(target).st_mode))
    if not os.path.isdir(target.parent):
        raise _refused(path, f"{target.parent} is no folder")
    _try(path, target.parent)


def check_replaced(path: Path, ending: str, start: bytes, kind: str) -> None:
    """Refuses a file for a result that is there and is none of its kind: it
    may be somebody's recording.

    Args:
        path: Where the result is to be.
        ending: That its name must have.
        start: How files of the kind begin.
        kind: What they are called.

    Raises:
        OutputError: One line: the place, and what is allowed.
    """
    path = Path(path)
    if path.suffix.lower() != ending:
        raise OutputError(f"{path}: allowed: *{ending}")
    check_file(path)
    if not os.path.exists(path):
        return
    try:
        found = ReadStart(path, len(start))
    except ReadError as error:
        raise OutputError(f"{path}: {error}") from error
    if found.lower() != start.lower():
        raise OutputError(f"{path}: exists and is no {kind}; not replaced")


def _check_depth(path: Path) -> None:
    if len(path.parts) > _MOST_PARTS:
        # Its name alone would fill the line.
        shown = "/".join(path.parts[:3])
        raise OutputError(
            f"{shown}/...: a path of {len(path.parts)} parts; allowed:"
            f" {_MOST_PARTS}"
        )


def _nearest(path: Path) -> Path:
    """The place itself, or what is there of the way to it."""
    for place in (path, *path.parents):
        try:
            os.lstat(place)
        except (FileNotFoundError, NotADirectoryError):
            continue
        # A name that no file can have is no text that can be encoded.
        except (OSError, ValueError) as error:
            raise _refused(path, reason(error)) from error
        return place
    return path


def _try(path: Path, folder: Path) -> None:
    """Whether a folder takes files is known once it has taken one."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _refused(path, reason(error)) from error


def _refused(path: Path, why: str) -> OutputError:
    return OutputError(f"{path}: cannot write there: {why}")
