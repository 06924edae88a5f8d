"""How sure an answer is."""

from __future__ import annotations

import math

from brace_drake.selection import thresholds


def _logistic(x: float) -> float:
    return min(
        max(1.0 / (1.0 + math.exp(-x)), thresholds.LEAST_PROBABILITY),
        thresholds.MOST_PROBABILITY,
    )


def _calibrated(p: float) -> float:
    odds = math.log(p / (1.0 - p))
    return _logistic(thresholds.ODDS_OFFSET + thresholds.ODDS_SLOPE * odds)


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
    return _calibrated(max(right * whole, thresholds.LEAST_PROBABILITY))


def sure_of_no_gap(rest: float) -> float:
    """Probability that there is no gap; `rest` in units of the threshold."""
    return _calibrated(_logistic(4.0 * (1.0 - rest)))


def with_less_known(probability: float, known: float) -> float:
    """A probability drawn towards one half.

    Args:
        probability: With all that a campaign records.
        known: Share of that which is known.
    """
    return min(probability, 0.5 + (probability - 0.5) * known)


def sure_of_outside(short: float) -> float:
    """Probability that nothing in the library explains the gap.

    Args:
        short: Best explained share of what is asked for.
    """
    return _calibrated(_logistic(6.0 * (1.0 - short) + 0.5))
