"""How sure an answer is."""

from __future__ import annotations

import math

_LEAST, _MOST = 0.02, 0.98


def _logistic(x: float) -> float:
    return min(max(1.0 / (1.0 + math.exp(-x)), _LEAST), _MOST)


def sure_of_effects(contrast: float, rest: float, count: int) -> float:
    """Probability that the named effects are right, and all there are.

    Args:
        contrast: What the best rival leaves over what the winner leaves.
        rest: Share of the gap's amplitude that the winner leaves; in it
            another effect may hide.
        count: Number of effects named.
    """
    slope = 2.0 if count == 1 else 1.5
    right = _logistic(slope * math.log(max(contrast, 1e-3)) - 0.5)
    whole = _logistic(3.0 - 10.0 * max(rest, 0.0))
    return max(right * whole, _LEAST)


def sure_of_no_gap(rest: float) -> float:
    """Probability that there is no gap; `rest` in units of the threshold."""
    return _logistic(4.0 * (1.0 - rest))


def sure_of_outside(short: float) -> float:
    """Probability that nothing in the library explains the gap.

    Args:
        short: Best explained share of what is asked for.
    """
    return _logistic(6.0 * (1.0 - short) + 0.5)
