"""Results on disk: written aside, then renamed, or not at all."""

from __future__ import annotations

import json
import os
import uuid
from pathlib import Path

from brace_drake.errors import OutputError


def MakeFolder(path: Path) -> Path:
    """Makes a folder for results, with its parents.

    Raises:
        OutputError: It cannot be made or written to.
    """
    path = Path(path)
    probe = path / f".{uuid.uuid4().hex}"
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(
            f"{path}: cannot write there: {error.strerror}"
        ) from error
    return path


def WriteText(path: Path, text: str) -> None:
    """Writes a text file that appears only when it is complete.

    Raises:
        OutputError: It cannot be written.
    """
    WriteBytes(path, text.encode("utf-8"))


def WriteBytes(path: Path, data: bytes) -> None:
    """Writes a file that appears only when it is complete.

    Raises:
        OutputError: It cannot be written.
    """
    path = Path(path)
    draft = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
    try:
        draft.write_bytes(data)
        os.replace(draft, path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise OutputError(f"{path}: {error.strerror}") from error


def WriteJson(path: Path, document: dict) -> None:
    """Writes a document as JSON."""
    WriteText(path, json.dumps(document, indent=1, allow_nan=False) + "\n")
