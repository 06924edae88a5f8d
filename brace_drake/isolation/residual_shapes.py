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

from collections.abc import Callable

import numpy as np

from brace_drake.core.block_bootstrap import interval_of
from brace_drake.devices.declaration import MotionSignals
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.least_squares import beyond, orthonormal_basis
from brace_drake.identification.whitening import in_pieces

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


def describe_rest(
    evaluator: Evaluator,
    fit: CandidateFit,
    signals_of: Callable[[PreparedRun, np.ndarray], MotionSignals],
    rate: float,
    seed: int,
) -> list[dict]:
    """What a fit leaves in each channel, the most first; none within the noise.

    Args:
        evaluator: Over the runs of the fit.
        fit: With its residual and Jacobian.
        signals_of: From a run and the subject's values to its motion.
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
    rests = in_pieces(evaluator, residual)
    noise = evaluator.noise_level(fit.uses)
    signals = [signals_of(run, fit.subject) for run in evaluator.prepared]
    motions = [motion_shapes(s.position, rate) for s in signals]
    found = []
    for c, name in enumerate(evaluator.twin.channels):
        rest = np.array([p[:, c] @ p[:, c] for p in rests])
        floor = noise * np.array([np.count_nonzero(p[:, c]) for p in rests])
        total, chance = rest.sum(), floor.sum()
        spread = 4.0 * np.sqrt(2.0 * chance)
        if chance == 0.0 or total < chance * (1.0 + _TRUST) + spread:
            continue
        shapes = _shapes_in(evaluator, motions, c, basis)
        taken = [(residual @ s) ** 2 / max(s @ s, 1e-300) for s in shapes]
        best = int(np.argmax(taken))
        parts = in_pieces(evaluator, shapes[best])
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


def _shapes_in(evaluator, motions, channel, basis) -> list[np.ndarray]:
    """Weighted shapes in one channel of all runs, beyond a basis (rows,)."""
    found = []
    for shape in SHAPES:
        parts = []
        for run, shapes in zip(evaluator.prepared, motions, strict=True):
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


def _share_of(table: np.ndarray, shape: str, seed: int) -> dict:
    """Share that a shape takes, from sums over pieces (n, 4)."""

    def share(weights):
        rest, noise, across, own = weights @ table
        if rest <= noise or own <= 0.0:
            return 0.0
        taken = (across**2 / own - 1.0) / (rest - noise)
        return float(np.clip(taken, 0.0, 1.0))

    low, high = interval_of(share, len(table), [seed, 53])
    is_found = low > _LEAST
    return {
        "shape": shape if is_found else None,
        "acts_like": SHAPES[shape] if is_found else None,
        "takes": share(np.ones(len(table))),
        "lower95": float(low),
        "upper95": float(high),
    }
