"""The whole diagnosis of a campaign: where, which, how far and what next."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.core.parallel import Workers
from brace_drake.core.progress import part_of
from brace_drake.design.next_run import NextRun, choose_next_run
from brace_drake.devices.choice import Choice
from brace_drake.devices.declaration import Device, Nuisance
from brace_drake.devices.device import MakeDevice, check_room
from brace_drake.devices.nominal_scenario import (
    NominalScenario,
    choose_scenario,
)
from brace_drake.discrepancy import FoundLaw, LawSearch, find_law
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import RunComparison, compare_runs
from brace_drake.identification.intervals import EstimateTable, estimate_table
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import (
    check_motion,
    estimate_floors,
    prepare_runs,
)
from brace_drake.isolation.block_tests import NUM_MACHINES, run_block_tests
from brace_drake.isolation.decision import accused_blocks
from brace_drake.isolation.locate import locate_gap
from brace_drake.isolation.residual_shapes import describe_rest
from brace_drake.recording.recording import Campaign
from brace_drake.recording_faults import Finding, check_recording
from brace_drake.recording_faults.against_twin import (
    Maker,
    find_recording_faults,
)
from brace_drake.recording_faults.check import without_false_repeats
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.decision import Verdict, decide
from brace_drake.selection.level import make_criterion
from brace_drake.selection.search.search import search_causes
from brace_drake.selection.settle import set_within, settle
from brace_drake.validation.causes import Cause, one_of_each, rank_causes
from brace_drake.validation.confirm import confirm, without_copies
from brace_drake.validation.new_runs import weigh_on_new_runs
from brace_drake.validation.prediction import predict_runs
from brace_drake.validation.shrinkage import measure_shrinkage
from brace_drake.validation.support import Closed


@dataclass(frozen=True)
class Diagnosis:
    """All results of a diagnosis, before they are written down.

    Attributes:
        campaign, device, seed: What was diagnosed.
        scenario: Of the nominal twin, and who has named it.
        choice: Which effects were searched, what of the subject was fitted.
        evaluator: Over the fit runs.
        floor_ratios: By channel, what repeats' noise has of the twin's.
        nominal: Fit of the subject alone.
        block_tests: Rows of the block tests.
        fits: Of all causes.
        criterion: By which they were judged.
        copies: Validation runs that repeat a fit run to the last digit; they
            were not looked at.
        nuisances: Numbers known to a tolerance.
        verdict: Which effects explain the gap.
        estimates: Parameters of the winner, else of the nominal fit.
        fit_runs, validation_runs: Before and after the repair.
        shrinkage: How far the gap shrinks on the validation runs.
        closed: What each named effect closes by itself.
        causes: Ranked, with what was decided of each.
        where: The gap by block, channel, phase and band.
        rest: What the best twin leaves, by the motion that it goes with.
        blocks: In which the gap lies.
        law: Of what no effect of the library explains, where one holds.
        next_run: The run that would settle what is open.
        recording: Faults of the recording itself; where one is certain, the
            gap is its, and no verdict on the machine counts.
    """

    campaign: Campaign
    device: Device
    scenario: NominalScenario
    choice: Choice
    seed: int
    evaluator: Evaluator
    floor_ratios: dict[str, float]
    nominal: CandidateFit
    block_tests: list[dict]
    fits: list[CandidateFit]
    criterion: Criterion
    copies: tuple[str, ...]
    nuisances: list[Nuisance]
    verdict: Verdict
    estimates: EstimateTable
    fit_runs: list[RunComparison]
    validation_runs: list[RunComparison]
    shrinkage: dict | None
    closed: dict[str, Closed]
    causes: list[Cause]
    where: dict
    rest: list[dict]
    blocks: list[str]
    law: FoundLaw | None
    next_run: NextRun | None
    recording: tuple[Finding, ...] = ()

    @property
    def repair(self) -> CandidateFit | None:
        """The fit with all that was found, its law included; None without."""
        return self.law.fit if self.law else self.verdict.winner


def diagnose(
    campaign: Campaign,
    jobs: int | Workers = 2,
    seed: int = 0,
    scenario=None,
    progress: Callable[[str, float], None] | None = None,
    diagram: Callable | None = None,
    choice: Choice | None = None,
) -> Diagnosis:
    """Diagnoses a campaign.

    Args:
        campaign: Loaded and without errors.
        jobs: Threads, or workers; the result does not depend on their number.
        seed: Of all random draws.
        scenario: Of the device, or its file, other than the one that the
            campaign names or that comes with the package.
        progress: Called with what is being done and the share that is done.
        diagram: Makes the nominal Drake diagram from the campaign's numbers,
            where its device is one.
        choice: Which effects are searched, and what of the subject is fitted.

    Raises:
        CampaignError: The campaign has nothing to fit, no run of it moves, or
            its device is unknown.
        EffectError, FitError: What was chosen is not there.
        ScenarioError: It carries as many effects as a twin can.
    """
    say = progress or (lambda what, share: None)
    if not campaign.split("fit"):
        raise CampaignError(f"{campaign.path}: no run has split: fit")
    named = choose_scenario(campaign, scenario)
    device = MakeDevice(campaign, named, diagram)
    twin, rate = device.twin, campaign.rate_hz
    check_room(twin)
    choice = (choice or Choice()).over(named.choice)
    choice.limit_subject(twin)
    effects = choice.effects_of(twin)

    # What the files and the control law say before anything is fitted.
    recording = check_recording(campaign, device, seed)
    campaign = without_false_repeats(campaign, recording)

    say("noise floor", 0.0)
    usual = np.array([p.nominal for p in twin.subject])
    floors, ratios = estimate_floors(twin, campaign, usual, seed)
    runs = prepare_runs(twin, campaign.split("fit"), floors, rate, seed)
    check_motion(campaign.path, runs)
    evaluator = Evaluator(twin, runs, jobs, effects)

    say("fit of the subject", 0.05)
    nuisances = device.tolerances()
    nominal = fit_nominal(evaluator, nuisances, device.uses_off)

    say("block tests", 0.1)
    drawn = [device.draw_uses(seed + i) for i in range(NUM_MACHINES)]
    tests = run_block_tests(evaluator, device.block_tests, nominal, seed, drawn)

    # Which effects, with the subject fitted anew beside each; of a recording
    # that is wrong none is told.
    criterion = make_criterion(evaluator, nominal, nuisances)
    is_faulty = any(f.is_certain for f in recording)
    laws = LawSearch(evaluator)
    fits = []
    if not is_faulty:
        told = part_of(say, 0.15, 0.8)
        fits = search_causes(evaluator, criterion, told, laws.explains)
        criterion = replace(criterion, law=laws.law)
    say("verdict", 0.8)
    criterion, fits = settle(evaluator, criterion, fits)
    # What is compared from here on has no number farther off than the best.
    most = criterion.farthest(decide(criterion, fits).winner or nominal)
    carry = partial(set_within, evaluator, uses_off=device.uses_off, most=most)
    nominal, fits = carry(nominal), [carry(fit) for fit in fits]
    criterion = replace(criterion, nominal=nominal)

    say("validation runs", 0.9)
    runs, copies = without_copies(campaign)
    new = prepare_runs(twin, runs, floors, rate, seed + 1000)
    validation = Evaluator(twin, new, jobs)
    criterion, fits = weigh_on_new_runs(validation, criterion, fits)
    verdict = decide(criterion, fits)
    verdict, compared, closed = confirm(
        validation, criterion, verdict, fits, seed
    )
    winner, nominal = verdict.winner, criterion.nominal
    shrinkage = measure_shrinkage(device, compared, nominal.subject, seed)
    fits = one_of_each(criterion, fits, winner)
    predictions = predict_runs(
        validation, compared, winner, fits if verdict.gap else [], seed
    )
    causes = rank_causes(criterion, fits, verdict, predictions)

    best = winner or nominal
    estimates = estimate_table(evaluator, best, seed)

    if not is_faulty:
        is_right = not criterion.is_beyond_level(best)
        recording += find_recording_faults(
            device,
            campaign,
            Maker(
                partial(MakeDevice, scenario=scenario, diagram=diagram),
                partial(_explain, choice=choice, jobs=jobs),
            ),
            evaluator.prepared,
            validation.prepared,
            best,
            jobs,
            is_right,
            seed,
        )

    law = None
    if verdict.outside_library and not is_faulty:
        say("law of what is left", 0.95)
        law = find_law(
            device, laws, validation, criterion, best, compared, seed
        )
    repair = law.fit if law else winner

    say("where", 0.97)
    fit_runs = compare_runs(evaluator, nominal, winner)
    where = locate_gap(
        device, evaluator, nominal, verdict, repair, tests, fit_runs, seed
    )
    rest = []
    if verdict.gap:
        rest = describe_rest(evaluator, best, device.motion_signals, rate, seed)
    beside = law.blocks if law else ()
    blocks = accused_blocks(verdict, criterion, fits, tests, beside)
    next_run = choose_next_run(
        device, evaluator, criterion, fits, verdict, seed
    )
    return Diagnosis(
        campaign=campaign,
        device=device,
        scenario=named,
        choice=choice,
        seed=seed,
        evaluator=evaluator,
        floor_ratios=ratios,
        nominal=nominal,
        block_tests=tests,
        fits=fits,
        criterion=criterion,
        copies=copies,
        nuisances=nuisances,
        verdict=verdict,
        estimates=estimates,
        fit_runs=fit_runs,
        validation_runs=compared,
        shrinkage=shrinkage,
        closed=closed,
        causes=causes,
        where=where,
        rest=rest,
        blocks=blocks,
        law=law,
        next_run=next_run,
        recording=tuple(recording),
    )


def _explain(
    device: Device, runs: Sequence[PreparedRun], choice: Choice, jobs
) -> CandidateFit:
    """The best fit that effects come to on some of the runs alone."""
    effects = choice.effects_of(device.twin)
    evaluator = Evaluator(device.twin, runs, jobs, effects)
    nuisances = device.tolerances()
    nominal = fit_nominal(evaluator, nuisances, device.uses_off)
    criterion = make_criterion(evaluator, nominal, nuisances)
    fits = search_causes(evaluator, criterion, lambda what, share: None)
    criterion, fits = settle(evaluator, criterion, fits)
    return decide(criterion, fits).winner or nominal
