"""Readers of large libraries, each file in a process of its own.

A hostile file can end the process of a library that believes it, keep it for
hours, or take all memory. None of that is then ours.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from brace_drake.core.errors import BraceError, ReadError, quoted, reason
from brace_drake.core.places import real_path
from brace_drake.recording.importing.formats.cells import Table, Word
from brace_drake.recording.importing.formats.excel import read_excel
from brace_drake.recording.importing.formats.flatten import Arrays
from brace_drake.recording.importing.formats.hdf5 import read_hdf5
from brace_drake.recording.importing.formats.ros_bag import read_ros_bag

# Of each kind: its reader, the package it needs, what a file of it is called.
KINDS: dict[str, tuple[Callable[..., Arrays], str, str]] = {
    "hdf5": (read_hdf5, "h5py", "an HDF5 file"),
    "excel": (read_excel, "openpyxl", "an Excel file"),
    "ros bag": (read_ros_bag, "rosbags", "a ROS bag"),
}
_REFUSED = 2
_MEMORY = 4 << 30
# Time for a file: so much to begin, and for each MB, s.
_BEGIN_S, _FOR_A_MB_S = 8.0, 8.0


def read_apart(kind: str, path: Path, *more) -> Table:
    """Columns of a file by name, as a reader of `KINDS` has them.

    Args:
        kind: Key of `KINDS`.
        path: The file, or folder.
        more: What the reader takes beside the path.

    Raises:
        ReadError: One line, without the file's name.
    """
    sources = str(Path(__file__).resolve().parents[3])
    known = os.environ.get("PYTHONPATH", "")
    env = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, (sources, known))),
    }
    task = json.dumps([kind, str(real_path(path)), *more])
    try:
        done = subprocess.run(
            [sys.executable, "-m", __name__, task],
            capture_output=True,
            timeout=_BEGIN_S + _FOR_A_MB_S * _megabytes(path),
            env=env,
        )
    except subprocess.TimeoutExpired as error:
        raise ReadError("takes longer to read than its size allows") from error
    if done.returncode == _REFUSED:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        raise ReadError(lines[-1] if lines else f"not {KINDS[kind][2]}")
    if done.returncode != 0:
        raise ReadError(f"not {KINDS[kind][2]}: its reader broke down")
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as found:
        names = json.loads(str(found["names"]))
        columns = {name: found[f"c{i}"] for i, name in enumerate(names)}
        words = json.loads(str(found["words"]))
        return Table(columns, {n: Word(*w) for n, w in words.items()})


def _megabytes(path: Path) -> float:
    files = path.iterdir() if path.is_dir() else (path,)
    return sum(f.stat().st_size for f in files if f.is_file()) / 1e6


def _limit_memory() -> None:
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    except (ImportError, ValueError, OSError):
        # Where the system has no such limit the time still is one.
        pass


def _main(task: str) -> int:
    kind, path, *more = json.loads(task)
    reader, package, called = KINDS[kind]
    _limit_memory()
    try:
        columns = Table(reader(Path(path), *more))
    except ImportError:
        words = f"needs {package}: pip install -e '.[lab]'"
    except BraceError as error:
        words = str(error)
    except MemoryError:
        words = "takes more memory than is meant for it"
    # On a broken file a reader of another's format may raise any exception.
    except Exception as error:
        words = f"not {called}: {quoted(reason(error))}"
    else:
        memory = io.BytesIO()
        arrays = {f"c{i}": c for i, c in enumerate(columns.values())}
        arrays["names"] = np.array(json.dumps(list(columns)))
        arrays["words"] = np.array(json.dumps(columns.words))
        np.savez(memory, allow_pickle=False, **arrays)
        sys.stdout.buffer.write(memory.getvalue())
        return 0
    print(words, file=sys.stderr)
    return _REFUSED


if __name__ == "__main__":
    sys.exit(_main(sys.argv[1]))
