"""What is said of a bad value of a scenario: one line, and a hint."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from brace_drake.core.errors import ScenarioError


def fail(source: str, path: str, value, allowed: str) -> NoReturn:
    """Raises the one line of a bad value."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    shown = " ".join(repr(value).split())
    if len(shown) > 60:
        shown = shown[:57] + "..."
    # Keys of a file may be anything, even line breaks.
    path = path if path.isprintable() else repr(path)
    raise ScenarioError(f"{source}: {path} is {shown}; allowed: {allowed}")
