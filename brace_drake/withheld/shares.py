"""Shares of a small number of cases, with how far they can be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass

_Z = 1.959963984540054  # 97.5 % quantile of the normal distribution


def wilson_interval(hits: int, count: int) -> tuple[float, float]:
    """95 % interval of a share.

    Wilson, "Probable inference, the law of succession, and statistical
    inference", J. American Statistical Association 22, 1927.
    """
    if count == 0:
        return 0.0, 1.0
    share, z2 = hits / count, _Z * _Z
    middle = (share + z2 / (2 * count)) / (1 + z2 / count)
    spread = share * (1 - share) / count + z2 / (4 * count * count)
    half = _Z * math.sqrt(spread) / (1 + z2 / count)
    return max(0.0, middle - half), min(1.0, middle + half)


@dataclass(frozen=True)
class Share:
    """How many of how many."""

    hits: int
    count: int

    @property
    def value(self) -> float | None:
        """The share, None of nothing."""
        return self.hits / self.count if self.count else None

    def document(self) -> dict:
        """In JSON types."""
        return {
            "hits": self.hits,
            "count": self.count,
            "share": self.value,
            "interval": list(wilson_interval(self.hits, self.count)),
        }

    def __str__(self) -> str:
        share = self.value
        if share is None:
            return "no such case"
        low, high = wilson_interval(self.hits, self.count)
        return (
            f"{self.hits:3d} of {self.count:3d}  {100 * share:5.1f} %"
            f"  (95 %: {100 * low:.1f} to {100 * high:.1f})"
        )


def share_of(hits: list[bool]) -> Share:
    """The share of true ones."""
    return Share(sum(bool(h) for h in hits), len(hits))
