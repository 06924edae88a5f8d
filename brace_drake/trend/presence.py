"""Does an effect appear or disappear? A test of verdicts over time.

Each session names an effect or does not, and its verdict is wrong with a known
probability. Under the null the effect is always there, or never; then every
pattern of names comes from wrong verdicts alone. The statistic compares the
best single switch with the better of the two nulls; its probability under
either null is counted over all patterns, or drawn where there are too many.
"""

from __future__ import annotations

import numpy as np

# Sessions up to which all patterns are counted; draws beyond.
_MOST_COUNTED, _DRAWS = 14, 200_000
# No verdict is surer than this: the calibration rests on some hundred cases.
_LEAST_ERROR = 0.005


def switch_probability(
    named: np.ndarray, wrong: np.ndarray
) -> tuple[float, int | None]:
    """Tests the names of one effect for a single switch.

    Args:
        named: Whether each session names it, bool (n,), in order of time.
        wrong: Probability that the session's verdict is wrong (n,).

    Returns:
        Probability of so clear a switch where nothing switches, and the number
        of sessions before it; 1 and None where all sessions agree.
    """
    n = len(named)
    if n < 2 or named.all() or not named.any():
        return 1.0, None
    error = np.clip(wrong, _LEAST_ERROR, 0.5)
    truths = _truths(n)
    seen, at = _statistic(named[None, :], error, truths)
    worst = 0.0
    for truth in (False, True):
        patterns, weights = _patterns(error, truth)
        there, _ = _statistic(patterns, error, truths)
        worst = max(worst, float(weights[there >= seen[0] - 1e-9].sum()))
    return min(1.0, worst), int(at[0])


def _truths(n: int) -> np.ndarray:
    """What may be true (2 n, n): never, always, then each switch."""
    switched = np.arange(n) >= np.arange(1, n)[:, None]
    rows = [np.zeros((1, n), bool), np.ones((1, n), bool), switched, ~switched]
    return np.vstack(rows)


def _statistic(patterns, error, truths) -> tuple[np.ndarray, np.ndarray]:
    """Log likelihood of the best switch over the best null (m,), and where it
    is (m,).
    """
    # Where a pattern agrees with a truth its verdict was right.
    right, wrong = np.log1p(-error), np.log(error)
    loss = right - wrong
    given = np.where(patterns, 1.0, -1.0)
    claims = np.where(truths, 1.0, -1.0)
    # Disagreements weigh the loss: (loss - given claims loss) / 2.
    cost = 0.5 * (loss.sum() - (given * loss) @ claims.T)
    switches = cost[:, 2:]
    best = switches.argmin(axis=1)
    n = patterns.shape[1]
    gain = cost[:, :2].min(axis=1) - switches.min(axis=1)
    return gain, best % (n - 1) + 1


def _patterns(error: np.ndarray, truth: bool) -> tuple[np.ndarray, np.ndarray]:
    """Patterns of names under a null (m, n), and the weight of each (m,)."""
    n = len(error)
    if n <= _MOST_COUNTED:
        flips = (np.arange(2**n)[:, None] >> np.arange(n)) & 1 == 1
        weights = np.prod(np.where(flips, error, 1.0 - error), axis=1)
    else:
        generator = np.random.default_rng([n, 17])
        flips = generator.random((_DRAWS, n)) < error
        weights = np.full(_DRAWS, 1.0 / _DRAWS)
    return flips ^ truth, weights
