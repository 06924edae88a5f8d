"""Results on disk: written aside, then renamed, or not at all."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import uuid
from collections.abc import Mapping
from pathlib import Path

from brace_drake.core.errors import OutputError, reason
from brace_drake.core.places import check_folder

# Folders that this process holds, by their place on the disk.
_held: dict[tuple[int, int], int] = {}
# Folders that it has made, parents first.
_made: list[Path] = []


def MakeFolder(path: Path) -> Path:
    """Makes a folder for results, with its parents.

    Raises:
        OutputError: It cannot be made or written to.
    """
    path = Path(path)
    check_folder(path)
    probe = path / f".{uuid.uuid4().hex}"
    missing = [p for p in (path, *path.parents) if not p.exists()]
    try:
        path.mkdir(parents=True, exist_ok=True)
        _made.extend(reversed(missing))
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(
            f"{path}: cannot write there: {reason(error)}"
        ) from error
    return path


def HoldFolder(path: Path) -> Path:
    """Makes a folder that no other process holds, and holds it.

    Until `ReleaseFolder`, or the end of the process however it comes. A folder
    is held once for the whole process. Disks that know no locks hold nothing.

    Raises:
        OutputError: It cannot be made or written to, or another process holds
            it.
    """
    path = MakeFolder(path)
    fd = os.open(path, os.O_RDONLY)
    status = os.fstat(fd)
    place = status.st_dev, status.st_ino
    if place in _held:
        os.close(fd)
        return path
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(fd)
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            raise OutputError(
                f"{path}: another process is writing its results there"
            ) from error
        return path
    _held[place] = fd
    return path


def ReleaseFolder(path: Path) -> None:
    """Ends a hold; a folder that is not held stays as it is."""
    with contextlib.suppress(OSError):
        status = Path(path).stat()
        fd = _held.pop((status.st_dev, status.st_ino), None)
        if fd is not None:
            os.close(fd)


def ReleaseFolders() -> None:
    """Ends all holds of this process; what it made and left empty goes."""
    while _held:
        os.close(_held.popitem()[1])
    while _made:
        with contextlib.suppress(OSError):
            _made.pop().rmdir()


def WriteText(path: Path, text: str) -> None:
    """Writes a text file that appears only when it is complete.

    Raises:
        OutputError: It cannot be written.
    """
    WriteFiles({Path(path): text})


def WriteBytes(path: Path, data: bytes) -> None:
    """Writes a file that appears only when it is complete, and on the disk.

    A symbolic link stays, and its file is written.

    Raises:
        OutputError: It cannot be written, or it is a device or a pipe.
    """
    WriteFiles({Path(path): data})


def WriteFiles(files: Mapping[Path, str | bytes]) -> None:
    """Writes files that belong together: all contents, then all names, so that
    a full disk leaves none of them.

    Raises:
        OutputError: See `WriteBytes`.
    """
    drafts: list[tuple[Path, Path]] = []
    try:
        for path, content in files.items():
            path = _file_of(path)
            draft = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
            drafts.append((draft, path))
            _write(draft, content)
        for draft, path in drafts:
            os.replace(draft, path)
    except OSError as error:
        raise OutputError(
            f"{path}: cannot be written: {error.strerror}"
        ) from error
    finally:
        # Gone where all went well; on a read-only disk it never was.
        for draft, _ in drafts:
            with contextlib.suppress(OSError):
                draft.unlink(missing_ok=True)


def _write(path: Path, content: str | bytes) -> None:
    if isinstance(content, str):
        content = content.encode("utf-8", "backslashreplace")
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        # Else a machine that loses power may keep the name alone.
        os.fsync(file.fileno())


def _file_of(path: Path) -> Path:
    """Where a file is to be written; what is renamed would take the place of
    a link, or of a device.
    """
    try:
        target = path.resolve() if path.is_symlink() else path
        is_other = target.exists() and not target.is_file()
    except (OSError, RuntimeError) as error:
        why = getattr(error, "strerror", None) or "links to itself"
        raise OutputError(f"{path}: cannot be written: {why}") from error
    if is_other and not target.is_dir():
        raise OutputError(f"{path}: is no regular file")
    return target


def WriteJson(path: Path, document: dict) -> None:
    """Writes a document as JSON."""
    WriteText(path, format_json(document))


def format_json(document: dict) -> str:
    """A document as JSON."""
    return json.dumps(document, indent=1, allow_nan=False) + "\n"
