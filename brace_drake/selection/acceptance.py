"""What an explanation must take away, and what it may leave."""

from __future__ import annotations

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.measures import misfit

# An explanation must take away this much of the gap's amplitude: more where
# instruments and nominal numbers are given exactly, so that only the law of the
# effect itself may differ; by far most where a device is known by its recording
# alone.
MAJOR_KNOWN = 0.80
MAJOR_REAL = 0.75
# Mean square above the floor's, in floors, up to which a repaired twin counts
# as good: what is left may not be more than the noise.
_NEAR_FLOOR = 1.0
# Share of the gap's amplitude that two effects must take away at least: no law
# is exact to less than a hundredth of what it does; nor, where drives stick, is
# any twin to less than a tenth.
_MAJOR_EXACT, _MAJOR_ROUGH = 0.99, 0.90
# A race leaves this many times what the end of a search will leave, or less.
_UNFINISHED = 2.0
# What the coarse plant step of a race may put in, as a share of the gap.
_UNFINISHED_SHARE = 0.25


def smallest_share(evaluator: Evaluator) -> float:
    """Share of the gap's amplitude that an explanation must take away."""
    known = evaluator.twin.instruments_known
    return MAJOR_KNOWN if known else MAJOR_REAL


def largest_rest(
    evaluator: Evaluator,
    nominal: CandidateFit,
    number: int,
    is_rough: bool = False,
) -> float:
    """Mean square above the floor's that an explanation of most may leave.

    A real machine has more than one flaw, so one effect may leave a rest, if
    that is a small part of the gap's amplitude; on a bench with known
    instruments two effects together may leave no more than the noise, for with
    so much freedom much of any gap can be covered, or a hundredth of the gap's
    amplitude, where drives stick (`is_rough`) a tenth.
    """
    before = np.sqrt(1.0 + max(0.0, misfit(evaluator, nominal))) - 1.0
    most = _rest(before, smallest_share(evaluator))
    if number > 1 and evaluator.twin.instruments_known:
        share = _MAJOR_ROUGH if is_rough else _MAJOR_EXACT
        return min(most, max(_NEAR_FLOOR, _rest(before, share)))
    return most


def _rest(before: float, share: float) -> float:
    """Mean square left where a share of an amplitude is taken away."""
    return float((1.0 + (1.0 - share) * before) ** 2 - 1.0)


def largest_excess(
    evaluator: Evaluator, nominal: CandidateFit, number: int
) -> float:
    """Excess after a race from which an explanation may still be reached."""
    most = largest_rest(evaluator, nominal, number)
    coarse = min(_NEAR_FLOOR, _UNFINISHED_SHARE * misfit(evaluator, nominal))
    return max(_UNFINISHED * most, coarse) * evaluator.count


def is_almost_near_floor(evaluator: Evaluator, fit: CandidateFit) -> bool:
    """Whether a race leaves a fit where its end may be near the floor."""
    return misfit(evaluator, fit) <= _UNFINISHED * _NEAR_FLOOR


def is_near_enough(evaluator: Evaluator, fit: CandidateFit) -> bool:
    """Whether two effects that explain a gap leave no more than the noise
    itself, which where instruments are known they had to.
    """
    known = evaluator.twin.instruments_known
    return known or misfit(evaluator, fit) <= _NEAR_FLOOR
