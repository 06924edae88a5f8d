"""A campaign's verdict with numbers known to their tolerances."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices.device import MakeDevice
from brace_drake.experiments.within_tolerances.decision import Verdict, decide
from brace_drake.experiments.within_tolerances.fitted import fit_nominal_within
from brace_drake.experiments.within_tolerances.level import make_criterion
from brace_drake.experiments.within_tolerances.search import search_causes
from brace_drake.experiments.within_tolerances.settle import settle
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording.recording import Campaign


def judge_within_tolerances(
    campaign: Campaign,
    jobs: int = 2,
    seed: int = 0,
    scenario=None,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> Verdict:
    """Which effects a campaign shows beyond noise and tolerances.

    Args:
        campaign: Loaded and without errors.
        jobs: Threads; the result does not depend on their number.
        seed: Of all random draws.
        scenario: Of the device, with its tolerances.
        progress: Called with what is being done and the share that is done.

    Raises:
        CampaignError: No run to fit, or a device without a twin.
    """
    if not campaign.split("fit"):
        raise CampaignError(f"{campaign.path}: no run has split: fit")
    device = MakeDevice(campaign, scenario)
    twin, rate = device.twin, campaign.rate_hz
    usual = np.array([p.nominal for p in twin.subject])
    floors, _ = estimate_floors(twin, campaign, usual, seed)
    runs = prepare_runs(twin, campaign.split("fit"), floors, rate, seed)
    evaluator = Evaluator(twin, runs, jobs)
    nuisances = device.tolerances()
    nominal = fit_nominal_within(evaluator, nuisances)
    criterion = make_criterion(evaluator, nominal, nuisances)
    fits = search_causes(evaluator, criterion, progress)
    criterion, fits = settle(evaluator, criterion, fits)
    return decide(criterion, fits)
