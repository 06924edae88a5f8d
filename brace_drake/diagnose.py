"""The whole diagnosis of a campaign: where, which, how far and what next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.design.next_run import NextRun, choose_next_run
from brace_drake.devices.declaration import Device
from brace_drake.devices.device import MakeDevice, check_room
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit, fit_nominal
from brace_drake.identification.gap import RunComparison, compare_runs
from brace_drake.identification.intervals import EstimateTable, estimate_table
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.isolation.block_tests import holds_at_rest, run_block_tests
from brace_drake.isolation.decision import nearest_block, suspected_blocks
from brace_drake.isolation.imposed_motion import (
    explain_imposed_motion,
    fit_imposed_motion,
)
from brace_drake.isolation.locate import locate_gap
from brace_drake.isolation.residual_shapes import describe_rest
from brace_drake.recording.recording import Campaign
from brace_drake.recording_faults import Finding, check_recording
from brace_drake.recording_faults.against_twin import find_recording_faults
from brace_drake.recording_faults.check import without_false_repeats
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict, decide
from brace_drake.selection.search.search import search_causes
from brace_drake.selection.surrogate_data import loses_to_surrogates
from brace_drake.validation.causes import Cause, rank_causes
from brace_drake.validation.prediction import predict_runs
from brace_drake.validation.shrinkage import (
    compare_new_runs,
    measure_shrinkage,
)


@dataclass(frozen=True)
class Diagnosis:
    """All results of a diagnosis, before they are written down.

    Attributes:
        campaign, device, seed: What was diagnosed.
        evaluator: Over the fit runs.
        floor_ratios: By channel, what repeats' noise has of the twin's.
        nominal: Fit of the subject alone.
        block_tests: Rows of the block tests.
        fits: Of all causes.
        criterion: By which they were judged.
        is_cut: Whether the search for two effects at once ended early.
        shown: Effects that an imposed motion shows by itself.
        verdict: Which effects explain the gap.
        estimates: Parameters of the winner, else of the nominal fit.
        fit_runs, validation_runs: Before and after the repair.
        shrinkage: How far the gap shrinks on the validation runs.
        causes: Ranked, with what was decided of each.
        where: The gap by block, channel, phase and band.
        rest: What the best twin leaves, by the motion that it goes with.
        blocks: In which the gap lies.
        next_run: The run that would settle what is open.
        recording: Faults of the recording itself; where one is certain, the
            gap is its, and no verdict on the machine counts.
    """

    campaign: Campaign
    device: Device
    seed: int
    evaluator: Evaluator
    floor_ratios: dict[str, float]
    nominal: CandidateFit
    block_tests: list[dict]
    fits: list[CandidateFit]
    criterion: Criterion
    is_cut: bool
    shown: frozenset[str]
    verdict: Verdict
    estimates: EstimateTable
    fit_runs: list[RunComparison]
    validation_runs: list[RunComparison]
    shrinkage: dict | None
    causes: list[Cause]
    where: dict
    rest: list[dict]
    blocks: list[str]
    next_run: NextRun | None
    recording: tuple[Finding, ...] = ()


def diagnose(
    campaign: Campaign,
    jobs: int = 2,
    seed: int = 0,
    scenario=None,
    progress: Callable[[str, float], None] | None = None,
) -> Diagnosis:
    """Diagnoses a campaign.

    Args:
        campaign: Loaded and without errors.
        jobs: Threads; the result does not depend on their number.
        seed: Of all random draws.
        scenario: Of the device, other than the one that comes with the
            package.
        progress: Called with what is being done and the share that is done.

    Raises:
        CampaignError: The campaign has nothing to fit, or an unknown device.
        ScenarioError: It carries as many effects as a twin can.
    """
    say = progress or (lambda what, share: None)
    if not campaign.split("fit"):
        raise CampaignError(f"{campaign.path}: no run has split: fit")
    device = MakeDevice(campaign, scenario)
    twin, rate = device.twin, campaign.rate_hz
    check_room(twin)

    # What the files and the control law say before anything is fitted.
    recording = check_recording(campaign, device, seed)
    campaign = without_false_repeats(campaign, recording)

    say("noise floor", 0.0)
    usual = np.array([p.nominal for p in twin.subject])
    floors, ratios = estimate_floors(twin, campaign, usual, seed)
    runs = prepare_runs(twin, campaign.split("fit"), floors, rate, seed)
    evaluator = Evaluator(twin, runs, jobs)

    say("fit of the subject", 0.05)
    nominal = fit_nominal(evaluator)

    say("block tests", 0.08)
    tests = run_block_tests(evaluator, device.block_tests, nominal, seed)
    at_rest = holds_at_rest(tests)
    # Of leg lengths that are off no motion can be told.
    twin_on_way = None if at_rest is False else device.imposed
    on_way = cache(
        partial(fit_imposed_motion, twin_on_way, campaign, jobs, seed)
    )

    # Which effects, with the subject fitted anew beside each.
    fits, criterion, is_cut, shown = search_causes(
        evaluator,
        nominal,
        seed,
        say,
        at_rest,
        lambda say: on_way() and explain_imposed_motion(on_way(), seed, say),
    )
    say("verdict", 0.8)
    is_chance = partial(loses_to_surrogates, evaluator, nominal, seed=seed)
    verdict = decide(criterion, fits, is_chance, shown)
    winner = verdict.winner
    estimates = estimate_table(evaluator, winner or nominal, seed)

    say("validation runs", 0.94)
    runs = campaign.split("validation")
    new = prepare_runs(twin, runs, floors, rate, seed + 1000)
    validation = Evaluator(twin, new, jobs)
    compared = compare_new_runs(validation, nominal, winner)
    shrinkage = measure_shrinkage(device, compared, nominal.subject, seed)
    rivals = fits if verdict.gap else []
    predictions = predict_runs(validation, compared, winner, rivals, seed)
    causes = rank_causes(evaluator, criterion, fits, verdict, predictions, seed)

    if not any(f.is_certain for f in recording):
        best = winner or nominal
        recording += find_recording_faults(
            device, evaluator.prepared, validation.prepared, best, jobs
        )

    say("where", 0.96)
    fit_runs = compare_runs(evaluator, nominal, winner)
    imposed = on_way() if verdict.outside_library else None
    where = locate_gap(
        device, evaluator, nominal, verdict, tests, imposed, fit_runs, seed
    )
    rest, blocks = [], []
    if verdict.gap:
        best = winner or nominal
        rest = describe_rest(evaluator, best, device.motion_signals, rate, seed)
    if winner is not None:
        blocks = list(dict.fromkeys(e.block for e in winner.effects))
    elif verdict.outside_library:
        blocks = nearest_block(criterion, fits) or suspected_blocks(
            tests, where["balance"], where["contact_side"]
        )
    next_run = choose_next_run(
        device, evaluator, criterion, fits, verdict, seed
    )
    return Diagnosis(
        campaign=campaign,
        device=device,
        seed=seed,
        evaluator=evaluator,
        floor_ratios=ratios,
        nominal=nominal,
        block_tests=tests,
        fits=fits,
        criterion=criterion,
        is_cut=is_cut,
        shown=shown,
        verdict=verdict,
        estimates=estimates,
        fit_runs=fit_runs,
        validation_runs=compared,
        shrinkage=shrinkage,
        causes=causes,
        where=where,
        rest=rest,
        blocks=blocks,
        next_run=next_run,
        recording=tuple(recording),
    )
