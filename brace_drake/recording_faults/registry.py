"""All recording faults: every CARD in the folders of `library`."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

import brace_drake.recording_faults.library as library
from brace_drake.recording_faults.card import RecordingFault


@cache
def all_recording_faults() -> dict[str, RecordingFault]:
    """Cards by name."""
    found = {}
    for module in pkgutil.walk_packages(
        library.__path__, f"{library.__name__}."
    ):
        card = getattr(importlib.import_module(module.name), "CARD", None)
        if card is not None:
            found[card.name] = card
    return found
