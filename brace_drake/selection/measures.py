"""What fits leave, take and close: the figures that a verdict rests on."""

from __future__ import annotations

import numpy as np

from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection.null_bootstrap import NullDistribution

# Mean square, in floors, up to which a twin of the right effect is trusted to
# follow a recording: a tenth of the floor's amplitude and a bit.
EXACT_TO = 0.02
# About half of the gap's amplitude: what a flexible effect has to close, and an
# effect beside which a second one is looked for.
_HALF = 0.5


def misfit(evaluator: Evaluator, fit: CandidateFit) -> float:
    """Mean square above the floor's, in floors."""
    return fit.excess / evaluator.count


def gain(
    evaluator: Evaluator, nominal: CandidateFit, fit: CandidateFit
) -> float:
    """What a fit takes off the nominal fit's mean square."""
    return (nominal.excess - fit.excess) / evaluator.count


def gains(
    evaluator: Evaluator,
    before: CandidateFit,
    fit: CandidateFit,
    null: NullDistribution,
) -> bool:
    """Whether a fit takes more off another one's mean square than noise and
    the twin's own errors would give to as many parameters more.
    """
    more = max(1, fit.freedom - before.freedom)
    return gain(evaluator, before, fit) > null.least_gain(more)


def closed_amplitude(
    evaluator: Evaluator, nominal: CandidateFit, fit: CandidateFit
) -> float:
    """Share of the gap's amplitude that a fit takes away, 1 at the floor."""
    before = np.sqrt(1.0 + max(0.0, misfit(evaluator, nominal))) - 1.0
    after = np.sqrt(1.0 + max(0.0, misfit(evaluator, fit))) - 1.0
    return float(1.0 - after / before) if before > 0.0 else 0.0


def closes_half(
    evaluator: Evaluator, nominal: CandidateFit, fit: CandidateFit
) -> bool:
    """Whether a fit takes away about half of the gap's amplitude."""
    return closed_amplitude(evaluator, nominal, fit) >= _HALF


def is_flexible(fit: CandidateFit) -> bool:
    """Whether one of the effects has dozens of parameters."""
    return any(e.is_flexible for e in fit.effects)


def left_over(evaluator: Evaluator, fit: CandidateFit) -> float:
    """Mean square above the floor's and what no twin is exact to."""
    return max(0.0, misfit(evaluator, fit)) + EXACT_TO


def is_exact(evaluator: Evaluator, fit: CandidateFit) -> bool:
    """Whether a fit follows the recording as far as any twin is trusted to."""
    return misfit(evaluator, fit) <= EXACT_TO
