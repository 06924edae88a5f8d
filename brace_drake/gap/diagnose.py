"""The whole diagnosis: fit, gap, causes, repair, and what it rests on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brace_drake.campaign.recording import Campaign
from brace_drake.effects.registry import effects_for
from brace_drake.errors import BraceError, CampaignError
from brace_drake.gap.candidates import CandidateFit, fit_effects, fit_nominal
from brace_drake.gap.devices import Device, MakeDevice
from brace_drake.gap.evaluation import Evaluator
from brace_drake.gap.ladder import climb
from brace_drake.gap.prepare import estimate_floors, prepare_runs
from brace_drake.gap.shrink import RunComparison, compare_runs
from brace_drake.gap.surrogates import NullDistribution, draw_null
from brace_drake.gap.uncertainty import EstimateTable, estimate_table
from brace_drake.gap.verdict import Verdict, decide, explains, has_gap

# A rival whose screening leaves this many times the leader's rest is out.
_CONTENDER = 1.5
_MAX_CONTENDERS = 2

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Diagnosis:
    """All results of a diagnosis, before they are written down."""

    campaign: Campaign
    device: Device
    evaluator: Evaluator
    nominal: CandidateFit
    fits: list[CandidateFit]
    refined: set[str]
    null: NullDistribution
    verdict: Verdict
    table: EstimateTable
    ladder: list[dict]
    fit_runs: list[RunComparison]
    validation_runs: list[RunComparison]
    floor_ratios: dict[str, float]
    seed: int


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
    """
    say = progress or (lambda what, share: None)
    if not campaign.split("fit"):
        raise CampaignError(f"{campaign.path}: no run has split: fit")
    device = MakeDevice(campaign, scenario)
    twin = device.twin
    say("noise floor", 0.0)
    nominal_values = np.array([p.nominal for p in twin.subject])
    floors, ratios = estimate_floors(twin, campaign, nominal_values, seed)
    rate = campaign.rate_hz
    fit_runs = prepare_runs(twin, campaign.split("fit"), floors, rate, seed)
    evaluator = Evaluator(twin, fit_runs, jobs)
    say("fit of the subject", 0.05)
    nominal = fit_nominal(evaluator)
    fits, refined, null = _try_causes(evaluator, nominal, seed, say)
    say("verdict", 0.8)
    verdict = decide(evaluator, nominal, fits, null, seed)
    chosen = verdict.winner or nominal
    table = estimate_table(evaluator, chosen, seed)
    say("substitution of blocks", 0.88)
    ladder = climb(evaluator, device.rungs, nominal, seed)
    say("validation runs", 0.94)
    validation = Evaluator(
        twin,
        prepare_runs(
            twin, campaign.split("validation"), floors, rate, seed + 1000
        ),
        jobs,
    )
    return Diagnosis(
        campaign,
        device,
        evaluator,
        nominal,
        fits,
        refined,
        null,
        verdict,
        table,
        ladder,
        compare_runs(evaluator, nominal, verdict.winner),
        compare_runs(validation, nominal, verdict.winner),
        ratios,
        seed,
    )


def _try_causes(evaluator, nominal, seed, say):
    """Screens all effects, refines the contenders, adds a pair if need be."""
    cards = list(effects_for(evaluator.twin.device).values())
    fits = []
    for i, effect in enumerate(cards):
        say(f"cause {effect.name}", 0.1 + 0.4 * i / len(cards))
        fit = _attempt(evaluator, [effect], nominal)
        if fit is not None:
            fits.append(fit)
    refined: set[str] = set()
    say("contenders", 0.5)
    fits = _refine(evaluator, nominal, fits, refined)
    null = draw_null(evaluator, nominal, fits, seed)
    singles = [f for f in fits if explains(evaluator, nominal, f, null)]
    if not singles and has_gap(evaluator, nominal, fits, null) and fits:
        leader = min(fits, key=lambda f: f.excess)
        pairs = []
        for i, effect in enumerate(cards):
            if effect.name == leader.name or effect.spread is not None:
                # With dozens of parameters beside it any effect looks right.
                continue
            say(f"pair with {effect.name}", 0.6 + 0.2 * i / len(cards))
            pair = _attempt(
                evaluator, [*leader.effects, effect], nominal, leader
            )
            if pair is not None:
                pairs.append(pair)
        pairs = _refine(evaluator, nominal, pairs, refined)
        best = min(pairs, key=lambda f: f.excess, default=None)
        if best is not None:
            fits.append(best)
    return fits, refined, null


def _attempt(evaluator, effects, nominal, leader=None):
    try:
        return fit_effects(
            evaluator, effects, nominal, leader=leader, thorough=False
        )
    except (BraceError, ValueError):
        # A candidate whose twin cannot even run explains nothing.
        return None


def _refine(evaluator, nominal, fits, refined):
    ranked = sorted(fits, key=lambda f: f.excess)
    out = []
    for i, fit in enumerate(ranked):
        best = max(ranked[0].excess, 0.0) + 0.01 * evaluator.count
        if i < _MAX_CONTENDERS and fit.excess <= _CONTENDER * best:
            fit = fit_effects(evaluator, fit.effects, nominal, fit)
            refined.add(fit.name)
        out.append(fit)
    return out
