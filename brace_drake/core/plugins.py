"""What installed packages add by entry points."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator
from typing import TypeVar

from brace_drake.core.errors import BraceError

Kind = TypeVar("Kind")


def load_plugins(
    group: str, kind: type[Kind], what: str, error: type[BraceError]
) -> Iterator[Kind]:
    """What the entry points of a group hold.

    Args:
        group: Of the entry points.
        kind: That each of them has to be.
        what: What is added, in a word, such as effect.
        error: Raised where one cannot be loaded, or is of another kind.
    """
    for point in importlib.metadata.entry_points(group=group):
        try:
            card = point.load()
        except Exception as reason:
            raise error(f"{what} {point.value}: {reason}") from reason
        if not isinstance(card, kind):
            raise error(f"{point.value} is no {what}'s card")
        yield card
