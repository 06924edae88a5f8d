"""Where models, scenarios and compiled code lie; all of the twin asks here."""

import contextlib
import os
import stat
import sys
import tempfile
from functools import cache
from pathlib import Path

from brace_drake.core.errors import one_line

_NAME = "brace_drake"
_PACKAGE = Path(__file__).resolve().parents[1]


def _data_root(name: str) -> Path:
    installed = _PACKAGE / "_data" / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


def sdf_path(name: str) -> Path:
    """Path of a model in `sdf/`, from the source tree or from the wheel."""
    return _data_root("sdf") / name


def example_campaign_path() -> Path:
    """Path of the recorded example; it comes with the source tree alone."""
    return _PACKAGE.parent / "tests" / "data" / "example"


def scenario_path(name: str) -> Path:
    """Path of a scenario in `diagrams/`, source tree or wheel."""
    return _data_root("diagrams") / name


def policy_path(name: str = "rlpic.npz") -> Path:
    """Path of a trained policy in `policies/`, source tree or wheel."""
    return _data_root("policies") / name


def cache_path(name: str = "") -> Path:
    """Path of what is kept between runs, in the user's cache folder; where
    that takes no files in a temporary one that is the user's alone.
    """
    return _kept_in(wanted_cache_path()) / name


def wanted_cache_path() -> Path:
    """The user's cache folder, whether it takes files or not."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    # A user without a name has no home, and keeps the sign for it.
    return Path(base or os.path.expanduser("~/.cache")) / _NAME


@cache
def takes_files(folder: Path) -> bool:
    """Whether a folder can be written to; it is made where there is none."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(2**16))
    except OSError:
        return False
    return True


@cache
def _kept_in(wanted: Path) -> Path:
    """The folder itself, or the temporary one, which is told when it is made.

    Code is kept there: one that others could write to is not taken.
    """
    if wanted.parts[0] != "~" and takes_files(wanted):
        return wanted
    try:
        other = Path(tempfile.gettempdir()) / f"{_NAME}-{os.getuid()}"
        other.mkdir(mode=0o700)
        tell_note(
            f"{wanted} takes no files: what is compiled is kept in {other};"
            " XDG_CACHE_HOME names another place"
        )
    except FileExistsError:
        pass
    except OSError:
        return wanted
    status = os.lstat(other)
    is_own = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
    if is_own and not status.st_mode & 0o077 and takes_files(other):
        return other
    return wanted


def tell_note(text: str) -> None:
    """Prints a line on standard error, where there is such."""
    with contextlib.suppress(OSError, ValueError):
        print(f"brace-drake: {one_line(text)}", file=sys.stderr, flush=True)
