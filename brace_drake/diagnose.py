"""The whole diagnosis: fit, gap, causes, repair, and what it rests on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from brace_drake.core.errors import BraceError, CampaignError
from brace_drake.devices.device import Device, MakeDevice, check_room
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_nominal
from brace_drake.identification.intervals import EstimateTable, estimate_table
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.identification.run_parameters import (
    adapt_to_runs,
    has_run_parameters,
)
from brace_drake.isolation.block_tests import climb, holds_at_rest
from brace_drake.isolation.imposed_motion import (
    ContactSide,
    explain_contact_side,
    fit_contact_side,
)
from brace_drake.recording.recording import Campaign
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict, decide
from brace_drake.selection.search.search import search_causes
from brace_drake.selection.surrogate_data import loses_to_surrogates
from brace_drake.validation.prediction import Prediction, predict_runs
from brace_drake.validation.shrinkage import (
    RunComparison,
    compare_runs,
    repair_runs,
)

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Diagnosis:
    """All results of a diagnosis, before they are written down.

    `is_cut`: whether the search for two effects at once ended early; `side`:
    the contact's side alone, where that was needed to tell where a gap is.
    """

    campaign: Campaign
    device: Device
    evaluator: Evaluator
    nominal: CandidateFit
    fits: list[CandidateFit]
    criterion: Criterion
    verdict: Verdict
    table: EstimateTable
    ladder: list[dict]
    fit_runs: list[RunComparison]
    validation_runs: list[RunComparison]
    floor_ratios: dict[str, float]
    seed: int
    is_cut: bool = False
    predictions: Sequence[Prediction] = ()
    side: ContactSide | None = None


def diagnose(
    campaign: Campaign,
    jobs: int = 2,
    seed: int = 0,
    scenario=None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Diagnoses a campaign.

    Args:
        campaign: Loaded and without errors.
        jobs: Threads; the result does not depend on their number.
        seed: Of all random draws.
        scenario: Of the bench, other than the one that comes with the package.
        progress: Called with what is being done and the share that is done.

    Raises:
        CampaignError: The campaign has nothing to fit, or an unknown device.
        ScenarioError: It carries as many effects as a twin can.
    """
    say = progress or (lambda what, share: None)
    if not campaign.split("fit"):
        raise CampaignError(f"{campaign.path}: no run has split: fit")
    device = MakeDevice(campaign, scenario)
    twin = device.twin
    check_room(twin)
    say("noise floor", 0.0)
    nominal_values = np.array([p.nominal for p in twin.subject])
    floors, ratios = estimate_floors(twin, campaign, nominal_values, seed)
    rate = campaign.rate_hz
    fit_runs = prepare_runs(twin, campaign.split("fit"), floors, rate, seed)
    evaluator = Evaluator(twin, fit_runs, jobs)
    say("fit of the subject", 0.05)
    nominal = fit_nominal(evaluator)
    say("substitution of blocks", 0.08)
    ladder = climb(evaluator, device.rungs, nominal, seed)
    at_rest = holds_at_rest(ladder)
    # Of lengths that are off no way can be told.
    guided = None if at_rest is False else device.guided
    side = cache(partial(fit_contact_side, guided, campaign, jobs, seed))

    def see_side(say):
        return side() and explain_contact_side(side(), seed, say)

    fits, criterion, is_cut, shown = search_causes(
        evaluator, nominal, seed, say, at_rest, see_side
    )
    say("verdict", 0.8)
    is_chance = partial(loses_to_surrogates, evaluator, nominal, seed=seed)
    verdict = decide(criterion, fits, is_chance, shown)
    chosen = verdict.winner or nominal
    table = estimate_table(evaluator, chosen, seed)
    say("validation runs", 0.94)
    validation = Evaluator(
        twin,
        prepare_runs(
            twin, campaign.split("validation"), floors, rate, seed + 1000
        ),
        jobs,
    )
    compared = _compare_new(validation, nominal, verdict.winner)
    rivals = fits if verdict.gap else []
    return Diagnosis(
        campaign,
        device,
        evaluator,
        nominal,
        fits,
        criterion,
        verdict,
        table,
        ladder,
        compare_runs(evaluator, nominal, verdict.winner),
        compared,
        ratios,
        seed,
        is_cut,
        predict_runs(validation, compared, verdict.winner, rivals, rate, seed),
        side() if verdict.outside_library else None,
    )


def _compare_new(
    validation: Evaluator, nominal: CandidateFit, winner: CandidateFit | None
) -> list[RunComparison]:
    """Runs that no fit has seen, before the repair and after it; before it
    alone where the repaired twin breaks down on them.
    """
    compared = compare_runs(validation, nominal, None)
    if winner is None or not compared:
        return compared
    try:
        if has_run_parameters(winner):
            winner = adapt_to_runs(validation, winner)
        return repair_runs(validation, compared, winner)
    except BraceError:
        return compared
