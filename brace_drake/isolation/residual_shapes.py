"""What the best twin leaves, described by the motion that it goes with.

The rest r of a fit is compared with shapes that a motion could give a channel:
a constant, the time, the place, the speed and its size, the direction, the
acceleration. Of each shape only s counts, what no change of the fit's own
parameters takes, and

    ((r's)^2 / s's - noise) / (r_c'r_c - noise)

is the share that it takes of the rest r_c of its channel c, with one
coefficient for all runs. The shape that takes most tells what an effect that
the twin lacks acts like.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.design.separation import beyond, orthonormal_basis
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.whitening import in_time
from brace_drake.isolation.phases import MotionSignals

# Shapes, and what acts so.
SHAPES = {
    "constant": "an offset",
    "time": "a drift",
    "place": "a spring",
    "place squared": "a spring that is not linear",
    "speed": "a damper",
    "size of the speed": "a damper that is not the same in both directions",
    "direction": "dry friction",
    "acceleration": "a mass",
}
# Of the top speed, what counts as standing still.
_SLOW = 0.1
# The level of noise is trusted to so much of its mean square.
_TRUST = 0.1
_PIECE_S, _RESAMPLES = 1.0, 300
_MOST_ROWS = 5
# Relative length of a shape that is gone; least share that is worth a word.
_GONE, _LEAST = 1e-3, 0.1


def motion_shapes(position: np.ndarray, rate: float) -> dict[str, np.ndarray]:
    """Each of SHAPES along a motion (N,), in units of their own.

    Args:
        position: Along the motion (N,), m.
        rate: Hz.
    """
    speed = np.gradient(position) * rate
    slow = max(_SLOW * float(np.max(np.abs(speed))), 1e-12)
    place = position - position[0]
    shapes = (
        np.ones(len(position)),
        np.arange(len(position)) / rate,
        place,
        place**2,
        speed,
        np.abs(speed),
        np.tanh(speed / slow),
        np.gradient(speed) * rate,
    )
    return dict(zip(SHAPES, shapes, strict=True))


def describe_left(
    evaluator: Evaluator,
    fit: CandidateFit,
    signals: Sequence[MotionSignals],
    rate: float,
    seed: int,
) -> list[dict]:
    """What a fit leaves in each channel, the most first; none within the noise.

    Args:
        evaluator: Over the runs of the fit.
        fit: With its residual and Jacobian.
        signals: The motion of each run.
        rate: Hz.
        seed: Of the bootstrap over pieces of time.

    Returns:
        Rows with the channel's normalised RMS (1 is noise), its share of all
        that is left, the shape that takes most of it, what acts so, and the
        share that it takes with a 95 % interval; shape None where none takes
        more than chance would.
    """
    rows = evaluator.ends[-1]
    residual = fit.solution.residual[:rows]
    basis = orthonormal_basis(fit.solution.jacobian[:rows])
    rests = _in_pieces(evaluator, residual, rate)
    noise = evaluator.noise_level(fit.uses)
    found = []
    for c, name in enumerate(evaluator.twin.channels):
        rest = np.array([p[:, c] @ p[:, c] for p in rests])
        floor = noise * np.array([np.count_nonzero(p[:, c]) for p in rests])
        total, chance = rest.sum(), floor.sum()
        spread = 4.0 * np.sqrt(2.0 * chance)
        if chance == 0.0 or total < chance * (1.0 + _TRUST) + spread:
            continue
        shapes = _shapes_in(evaluator, signals, c, rate, basis)
        best = int(np.argmax([_taken(residual, s) for s in shapes]))
        parts = _in_pieces(evaluator, shapes[best], rate)
        pairs = list(zip(rests, parts, strict=True))
        across = [np.sum(r * s) for r, s in pairs]
        own = [np.sum(s * s) for _, s in pairs]
        table = np.column_stack([rest, floor, across, own])
        found.append(
            {
                "channel": name,
                "normalised_rms": float(np.sqrt(total / chance)),
                "share_of_rest": float(total - chance),
                **_share_of(table, list(SHAPES)[best], seed),
            }
        )
    left = sum(row["share_of_rest"] for row in found)
    for row in found:
        row["share_of_rest"] /= left
    found.sort(key=lambda row: -row["share_of_rest"])
    return found[:_MOST_ROWS]


def _shapes_in(evaluator, signals, channel, rate, basis) -> list[np.ndarray]:
    """Weighted shapes in one channel of all runs, beyond a basis (rows,)."""
    per_run = [motion_shapes(s.position, rate) for s in signals]
    found = []
    for shape in SHAPES:
        parts = []
        for run, shapes in zip(evaluator.prepared, per_run, strict=True):
            column = np.zeros_like(run.measured)
            column[:, channel] = shapes[shape]
            parts.append(run.weigh(column))
        weighted = np.concatenate(parts)
        size = np.linalg.norm(weighted)
        weighted = beyond(weighted, basis)
        # What the fit's parameters can do all of is no shape of its own.
        gone = np.linalg.norm(weighted) <= _GONE * size
        found.append(np.zeros_like(weighted) if gone else weighted)
    return found


def _taken(residual: np.ndarray, shape: np.ndarray) -> float:
    """Sum of squares that a shape takes."""
    own = shape @ shape
    return float((residual @ shape) ** 2 / own) if own > 0.0 else 0.0


def _in_pieces(evaluator, weighted, rate) -> list[np.ndarray]:
    """Series of unit variance, piece by piece of time of all runs (N, C)."""
    edges = [0, *evaluator.ends]
    found = []
    for run, begin, end in zip(
        evaluator.prepared, edges[:-1], edges[1:], strict=True
    ):
        series = in_time(run, weighted[begin:end])
        whole = np.zeros((len(series), len(run.used)))
        whole[:, run.used] = series
        duration = len(run.measured) / rate
        found += np.array_split(whole, max(1, round(duration / _PIECE_S)))
    return found


def _share_of(table: np.ndarray, shape: str, seed: int) -> dict:
    """Share that a shape takes, from sums over pieces (n, 4)."""
    generator = np.random.default_rng([seed, 53])
    count = len(table)
    draws = generator.multinomial(
        count, np.full(count, 1.0 / count), size=_RESAMPLES
    )
    share = _share(table.sum(axis=0))
    drawn = [_share(d @ table) for d in draws]
    low, high = np.quantile([*drawn, share], [0.025, 0.975])
    is_found = low > _LEAST
    return {
        "shape": shape if is_found else None,
        "acts_like": SHAPES[shape] if is_found else None,
        "takes": share,
        "lower95": float(low),
        "upper95": float(high),
    }


def _share(total: np.ndarray) -> float:
    rest, noise, across, own = total
    if rest <= noise or own <= 0.0:
        return 0.0
    return float(np.clip((across**2 / own - 1.0) / (rest - noise), 0.0, 1.0))
