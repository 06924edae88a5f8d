"""Fits with what the criterion asks of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.tolerances import linearise_tolerances
from brace_drake.experiments.within_tolerances import thresholds
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_nominal
from brace_drake.selection.search import shortlist
from brace_drake.validation.held_out import held_out_misfit

# Linearisations: at the usual subject, and at the fitted one.
_ROUNDS = 2


def fit_nominal_within(
    evaluator: Evaluator, nuisances: Sequence[Nuisance]
) -> CandidateFit:
    """Fits the subject's parameters alone.

    Args:
        evaluator: Over the fit runs; its residuals are whitened of the
            nuisances from here on.
        nuisances: Numbers known to a tolerance.
    """
    subject = np.array([p.nominal for p in evaluator.twin.subject])
    for _ in range(_ROUNDS if nuisances else 1):
        evaluator.tolerances = linearise_tolerances(
            evaluator, nuisances, subject
        )
        fit = fit_nominal(evaluator)
        subject = fit.subject
    return check_fit(evaluator, fit)


def try_refine(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """Leads a search to its end; the fit as it is where its twin breaks."""
    return check_fit(evaluator, shortlist.try_refine(evaluator, fit))


def estimate_off(evaluator: Evaluator, fit: CandidateFit) -> np.ndarray:
    """How many tolerances each number is off in a fit (k,); what else the fit
    leaves counts as noise.
    """
    known = evaluator.tolerances
    residual = fit.solution.residual[: evaluator.ends[-1]]
    rest = 1.0 + max(0.0, fit.excess) / evaluator.count
    return known.estimate(residual, rest)


def check_fit(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """The fit with what it leaves on motions left out, and how far it has to
    stretch tolerances.
    """
    stretch = 0.0
    if evaluator.tolerances is not None:
        stretch = float(np.max(np.abs(estimate_off(evaluator, fit))))
    left = held_out_misfit(evaluator, fit, thresholds.KEPT)
    return replace(fit, held_out=left, stretch=stretch)
