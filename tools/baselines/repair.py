"""Validation runs before and after a repair, as the diagnosis counts them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.replays import is_dithered
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import NUM_DITHERS
from brace_drake.identification.gap import RunComparison, closed_share, rms_gap
from tools.baselines.case import Case
from tools.baselines.linear import LEVEL, Linear, LinearFit
from tools.baselines.within import Tolerated

# Misfit up to which numbers with tolerances are told from what is left.
_NOISE_ALONE = 1.0


class Repair:
    """What a case's repaired twin closes.

    Attributes:
        within: Effects of the numbers with tolerances, where they seem to be
            in the nominal fit.
        before: Validation runs replayed by the nominal twin with them.
    """

    def __init__(self, case: Case):
        self._case, self._linear = case, Linear(case)
        self._tolerated = Tolerated(case)
        self.within = self._uses_within(None)
        dither, replays = self._replay(case.subject, self.within)
        prepared = case.bench.validation.prepared
        self.before = [
            RunComparison(p, replay, None, dither_before=dither)
            for p, replay in zip(prepared, replays, strict=True)
        ]

    def _uses_within(self, fit: LinearFit | None) -> list[Use]:
        """Numbers where they seem to be beside a fit; none beside one that
        leaves more than noise, which would pass for them.
        """
        misfit = self._linear.misfit if fit is None else fit.misfit
        if misfit > _NOISE_ALONE:
            return []
        effects = [] if fit is None else [s.effect for s in fit.signatures]
        along = self._linear.along_beside(fit)
        return self._tolerated.uses(along, effects)

    def _replay(
        self, subject: np.ndarray, uses: Sequence[Use]
    ) -> tuple[float, list[np.ndarray]]:
        evaluator = self._case.bench.validation
        limits = [(p.lower, p.upper) for p in evaluator.twin.subject]
        subject = np.clip(subject, *np.transpose(limits))
        is_noisy = is_dithered(evaluator.twin, uses)
        replays = [
            evaluator.simulate(p, subject, uses) for p in evaluator.prepared
        ]
        return 1.0 / NUM_DITHERS if is_noisy else 0.0, replays

    def closed_by(self, fit: LinearFit) -> float | None:
        """Share of the gap that a fit's effects close; None without a gap,
        where the twin breaks down, or where runs have columns of their own,
        of which others cannot be told.
        """
        pairs = zip(fit.signatures, fit.strengths, strict=True)
        uses = [s.use(strengths) for s, strengths in pairs]
        if any(use is None for use in uses):
            return None
        uses += self._uses_within(fit)
        subject = self._linear.subject_beside(fit)
        try:
            return self.closed(*reversed(self._replay(subject, uses)))
        except BraceError:
            return None

    def closed(
        self, replays: Sequence[np.ndarray], dither: float = 0.0
    ) -> float | None:
        """The same of predicted recordings (N, C) of the validation runs."""
        after = [
            RunComparison(c.prepared, c.before, x, dither, c.dither_before)
            for c, x in zip(self.before, replays, strict=True)
        ]
        ends = rms_gap(after, "before"), rms_gap(after, "after")
        return None if None in ends else closed_share(*ends)


def answer_of(
    linear: Linear, fit: LinearFit | None, probability: float
) -> dict:
    """What is said of a case whose best fit that is; None: no signature."""
    if fit is None:
        is_gap = linear.misfit > LEVEL
        return {"effects": [], "outside": is_gap, "probability": probability}
    told = {"blocks": fit.blocks, "probability": probability}
    if not linear.explains(fit):
        return {"effects": [], "outside": True, **told}
    names = list(dict.fromkeys(fit.names))
    closed = Repair(linear.case).closed_by(fit)
    return {"effects": names, "outside": False, **told, "closed": closed}
