"""What is said of a bad value of a scenario: one line, and a hint."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import NoReturn

import numpy as np

from brace_drake.errors import ScenarioError


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


def suggest(word: str, words: Iterable[str]) -> str:
    """A hint at the word that was meant, or nothing."""
    close = difflib.get_close_matches(str(word), list(words), n=1)
    return f", did you mean {close[0]}?" if close else ""
