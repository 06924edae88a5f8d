"""Open-loop replay on imposed motion: what answers to the ring's way.

Where drives stick and slip by chance a twin in closed loop comes to no floor,
and a second effect is lost in what it leaves. On the recorded way of the ring
nothing sticks: an effect of contact, torso or force reading shows there as it
would without friction, and so does the subject.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.core.parallel import Workers
from brace_drake.effects.registry import effects_for
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording.recording import Campaign
from brace_drake.selection.criterion import Criterion, make_criterion
from brace_drake.selection.decision import Verdict, decide
from brace_drake.selection.null_bootstrap import draw_null
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.screening import screen, search_best
from brace_drake.selection.search.shortlist import best_fits, refine
from brace_drake.selection.surrogate_data import loses_to_surrogates

# Mean square, in floors, from which on a gap is beyond doubt.
_LARGE = 0.5
# Times the floor's amplitude, up to which there is no gap: the noise of a way
# is known to a sixth.
_THRESHOLD = 1.17


@dataclass(frozen=True)
class ImposedMotionFit:
    """The subject's fit on the recorded way of the ring.

    Attributes:
        evaluator: Of the twin on imposed motion, over the fit runs.
        nominal: Its fit without effects.
    """

    evaluator: Evaluator
    nominal: CandidateFit

    def row(self) -> dict:
        """What the nominal fit leaves, as a row of block tests."""
        rest = max(0.0, self.nominal.excess / self.evaluator.count)
        ratio = float(np.sqrt(1.0 + rest))
        return {
            "block": "contact, torso and force reading",
            "input": "way of the ring",
            "output": "force, marker",
            "normalised_rms": ratio,
            "threshold": _THRESHOLD,
            "acquitted": ratio <= _THRESHOLD,
        }


def fit_imposed_motion(
    twin,
    campaign: Campaign,
    jobs: int | Workers,
    seed: int,
) -> ImposedMotionFit | None:
    """Fits the subject to what the way of the ring does to it.

    Args:
        twin: On imposed motion; None where the device has none.
        campaign: Its fit runs are looked at.
        jobs, seed: As of the diagnosis.

    Returns:
        None where there is no twin or one without room for effects, where way
        or force were not recorded or nothing was touched, and where the twin
        breaks down.
    """
    if twin is None or not twin.has_room:
        return None
    runs = tuple(campaign.split("fit"))
    recorded = all(run.has(twin.needs).all() for run in runs)
    if not (recorded and any(run.contact for run in runs)):
        return None
    usual = np.array([p.nominal for p in twin.subject])
    try:
        # Of a run held back nothing may be known, so not its way either.
        known = replace(campaign, runs=runs)
        floors, _ = estimate_floors(twin, known, usual, seed)
        prepared = prepare_runs(twin, runs, floors, campaign.rate_hz, seed)
        evaluator = Evaluator(twin, prepared, jobs)
        return ImposedMotionFit(evaluator, fit_nominal(evaluator))
    except (BraceError, ValueError):
        return None


def explain_imposed_motion(
    found: ImposedMotionFit,
    seed: int,
    say: Callable[[str, float], None] = lambda what, share: None,
) -> CandidateFit | None:
    """What answers otherwise than the twin to the imposed motion.

    Args:
        found: From `fit_imposed_motion`.
        seed: As of the diagnosis.
        say: Progress, shares of this search.

    Returns:
        The fit of the one effect that explains a gap beyond doubt, that of no
        effect where there is no gap, None where neither is known: as the noise
        of a way is known less than that of readings, and no twin is exact, a
        gap of less than half of the floor is none to build on.
    """
    evaluator, nominal = found.evaluator, found.nominal
    criterion = make_criterion(evaluator, nominal)
    try:
        base = Linearisation(evaluator, nominal)
        if criterion.misfit(nominal) <= _LARGE:
            null = draw_null(evaluator, nominal, [], seed)
            known = replace(criterion, null=null)
            return None if known.has_gap([]) else nominal
        verdict = _diagnose(base, criterion, seed, say)
    except (BraceError, ValueError):
        return None
    return None if verdict.ambiguous_with else verdict.winner


def _diagnose(
    base: Linearisation, criterion: Criterion, seed: int, say
) -> Verdict:
    evaluator, nominal = base.evaluator, base.base
    known = effects_for(evaluator.twin.device).values()
    effects = [e for e in known if e.answers_motion]
    most = criterion.largest_excess(1)
    few = [e for e in effects if not e.is_flexible]
    fits = _screen(base, few, most, say)
    null = draw_null(evaluator, nominal, fits, seed)
    criterion = replace(criterion, null=null)
    if not criterion.is_near_floor(fits):
        many = [e for e in effects if e.is_flexible]
        fits += _screen(base, many, most, say)
    is_chance = partial(loses_to_surrogates, evaluator, nominal, seed=seed)
    return decide(criterion, fits, is_chance)


def _screen(base, effects, most, say) -> list[CandidateFit]:
    found = screen(base, effects, say)
    search_best(base, found, say, enough=most)
    fits = best_fits(found)
    return refine(base.evaluator, fits, base.base.excess, rivals=most)
