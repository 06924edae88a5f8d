"""Fits beside numbers known to a tolerance, as these act there.

What a number that is off does depends on what else is there: where drives stick
a little, the ring answers to an anchor otherwise than where they do not, and to
a small error otherwise than to a large one. So tolerances are linearised again
where a fit stands, with its effects; where drives stick the numbers themselves
go along with it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.linearise import linearise_tolerances
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, finish_fit
from brace_drake.identification.least_squares import LeastSquaresSolution
from brace_drake.identification.numbers.numbers_along import fit_numbers_along
from brace_drake.identification.numbers.reweigh import noise_left, reweigh
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities
from brace_drake.selection import thresholds
from brace_drake.selection.search.shortlist import try_refine

# Linearisations of numbers that bend.
_ROUNDS = 2
# Largest steps of an iteration over which a number has hardly moved.
_MOVED = 0.5


def set_out(evaluator: Evaluator, fit: CandidateFit) -> None:
    """Takes tolerances as they are linearised at a fit."""
    known = fit.tolerances
    evaluator.tolerances = known and (known.whole or known)


def search_beside(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit:
    """A fit as a search sets out from it, with its tolerances taken.

    Numbers that are stretched along it have taken what may be an effect's, and
    would keep it. They are put back to their nominal values, on the straight
    lines that they have here, and weighed beside what the fit leaves: of that,
    too, a part may lie along them.
    """
    set_out(evaluator, fit)
    if fit.tolerances is None or fit.stretch <= thresholds.WITHIN:
        return fit
    noise = noise_left(evaluator, fit)
    evaluator.tolerances = evaluator.tolerances.at_zero.beside_noise(noise)
    fit = replace(fit, tolerances=fit.tolerances.at_zero)
    return try_refine(evaluator, fit)


def starts_beside(
    evaluator: Evaluator, fit: CandidateFit
) -> Iterator[CandidateFit]:
    """A fit as searches set out from it, one after the other: with its
    stretched numbers put back, and as it stands, where these stay off; last
    a machine as its twin was made.

    An effect that takes a part of what others are stretched for shows from
    the first alone, one that takes what all of these leave from the second.
    Where the numbers of the machine itself were bent to take an effect, it
    shows from those that the twin was made with.
    """
    beside = search_beside(evaluator, fit)
    yield beside
    if beside is not fit:
        set_out(evaluator, fit)
        yield fit
    made = None if fit.effects else _as_made(evaluator, fit)
    if made is not None:
        yield made


def _as_made(evaluator: Evaluator, fit: CandidateFit) -> CandidateFit | None:
    """The twin with the numbers that it was made with, not fitted; None where
    these are stated, or the fit has hardly moved them.
    """
    twin = evaluator.twin
    if not twin.finds_loop:
        return None
    problem = CandidateProblem(evaluator, ())
    z = np.array([p.nominal for p in twin.subject]) / problem.scales
    if np.all(np.abs(z - fit.solution.z) <= _MOVED * problem.radius):
        return None
    (residual,) = problem.batch([z], coarse=True)
    if residual is None:
        return None
    jacobian = calc_sensitivities(problem, z, base=residual)
    made = LeastSquaresSolution(z, residual, jacobian, 0, False)
    return finish_fit(problem, made, coarse=True)


def refit_alone(
    evaluator: Evaluator, fits: Sequence[CandidateFit]
) -> list[CandidateFit]:
    """Those of refined fits whose tolerances were weighed beside what was left,
    led on with these weighed beside the noise of the readings alone: so a
    verdict has them. What still lacks an effect stretches them more.
    """
    before, found = evaluator.tolerances, []
    for fit in fits:
        known = fit.tolerances
        if fit.refined and known is not None and known.noise > 1.0:
            set_out(evaluator, fit)
            evaluator.tolerances = evaluator.tolerances.beside_noise(1.0)
            found.append(try_refine(evaluator, fit))
    evaluator.tolerances = before
    return found


def refit_within(
    evaluator: Evaluator, fit: CandidateFit, nuisances: Sequence[Nuisance]
) -> CandidateFit:
    """A fit led to its end with tolerances linearised where it stands; as it
    is, or with those before, where that leaves no less.

    Args:
        evaluator: Over the fit runs; it keeps the linearisation, if the fit
            does.
        fit: That was searched.
        nuisances: Numbers known to a tolerance.
    """
    before, best = evaluator.tolerances, fit
    if nuisances and len(fit.effects) < evaluator.room:
        bends = fit.is_dithered and before.uses_off
        refit = _refit_along if bends else _refit_beside
        best = refit(evaluator, fit, nuisances)
    evaluator.tolerances = before
    if best is not fit:
        set_out(evaluator, best)
    elif not fit.refined:
        best = try_refine(evaluator, fit)
    return replace(best, is_settled=True)


def _refit_beside(
    evaluator: Evaluator, fit: CandidateFit, nuisances: Sequence[Nuisance]
) -> CandidateFit:
    """The better of a fit and the same beside numbers linearised there."""
    if not _linearise(evaluator, fit, nuisances):
        return fit
    again = try_refine(evaluator, fit)
    is_better = again.excess <= fit.excess or not fit.refined
    return again if again.refined and is_better else fit


def _refit_along(
    evaluator: Evaluator, fit: CandidateFit, nuisances: Sequence[Nuisance]
) -> CandidateFit:
    """A fit with the numbers along, linearised anew as long as that takes
    something; one whose numbers are off already first goes on as it is.
    """
    best, known = fit, fit.tolerances
    stands = known is not None and known.off is not None
    off = np.zeros(len(nuisances))
    for number in range(0 if stands else 1, _ROUNDS + 1):
        if number > 0 and not _linearise(evaluator, best, nuisances, off):
            break
        moved = fit_numbers_along(evaluator, best, is_anew=number > 0)
        if moved is None:
            break
        small = moved.excess > thresholds.WORTH_A_ROUND * best.excess
        best = moved
        set_out(evaluator, best)
        off = evaluator.tolerances.off
        if small:
            break
    if best.spread is None:
        return best
    # Many alike parameters have moved: so has the spread that they show.
    noise = noise_left(evaluator, best)
    evaluator.tolerances = evaluator.tolerances.beside_noise(noise)
    again = reweigh(evaluator, try_refine(evaluator, best), 1.0)
    return again if again.excess <= best.excess else best


def _linearise(
    evaluator: Evaluator,
    fit: CandidateFit,
    nuisances: Sequence[Nuisance],
    off: np.ndarray | None = None,
) -> bool:
    """Lets the evaluator have tolerances linearised at a fit; False where the
    twin breaks down there.
    """
    here = evaluator.tolerances
    near = here if here is not None and here.off is not None else None
    uses_off = here and here.uses_off
    noise = 1.0 if here is None else here.noise
    found = linearise_tolerances(
        evaluator, nuisances, fit.subject, fit.uses, uses_off, off, near, noise
    )
    if found is not None:
        evaluator.tolerances = found
    return found is not None
