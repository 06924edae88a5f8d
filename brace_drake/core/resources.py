"""Where models, scenarios and compiled code lie; all of the twin asks here."""

import os
from pathlib import Path

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
    """Path of what is kept between runs, in the user's cache folder."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "brace_drake" / name
