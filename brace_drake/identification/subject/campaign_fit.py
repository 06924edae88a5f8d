"""The fit of a campaign from recording to table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict

import numpy as np

from brace_drake.core.errors import CampaignError, FitError
from brace_drake.core.parallel import Workers
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.choice import Choice
from brace_drake.devices.device import MakeDevice
from brace_drake.devices.nominal_scenario import choose_scenario
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.intervals import estimate_table
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.identification.subject.contact_start import (
    contact_starts,
    start_values,
)
from brace_drake.identification.subject.subject_fit import fit_subject
from brace_drake.recording.recording import Campaign

FORMAT = "brace-fit/1"


def fit_campaign(
    campaign: Campaign,
    jobs: int | Workers = 2,
    seed: int = 0,
    scenario=None,
    solver: str = "snopt",
    on_evaluation: Callable[[int, float], None] | None = None,
    choice: Choice | None = None,
    diagram: Callable | None = None,
) -> dict:
    """Fits the subject's parameters to all fit runs of a campaign.

    The network of the paper's section 2.3 gives contact stiffness and damping
    to start from, a MathematicalProgram does the rest.

    Args:
        campaign: Loaded and without errors.
        jobs: Threads, or workers; the result does not depend on their number.
        seed: Of all random draws.
        scenario: Of the device, or its file, other than the one that the
            campaign names or that comes with the package.
        solver: snopt, ipopt or nlopt.
        on_evaluation: Called with their number and the mean square residual.
        choice: What of the subject is fitted; its effects are not looked at.
        diagram: Makes the nominal Drake diagram, where the device is one.

    Returns:
        A document of plain types: parameters with standard errors and limits,
        correlation, condition number, contact starts, solver.

    Raises:
        CampaignError: No run to fit, or a device without a twin.
        FitError: A chosen parameter is not there, or the solver is not; or
            the twin has no parameter to fit.
    """
    if not campaign.split("fit"):
        raise CampaignError(f"{campaign.path}: no run has split: fit")
    named = choose_scenario(campaign, scenario)
    twin = MakeDevice(campaign, named, diagram).twin
    if not twin.subject:
        raise FitError(
            f"{campaign.path}: the twin has no parameter of a subject to fit"
        )
    choice = (choice or Choice()).over(named.choice)
    choice.limit_subject(twin)
    starts = []
    values = np.array([p.nominal for p in twin.subject])
    if isinstance(twin, BenchTwin):
        starts = contact_starts(twin, campaign)
        values = start_values(twin, starts)
    floors, _ = estimate_floors(twin, campaign, values, seed)
    runs = prepare_runs(
        twin, campaign.split("fit"), floors, campaign.rate_hz, seed
    )
    evaluator = Evaluator(twin, runs, jobs)
    fit, report = fit_subject(evaluator, values, solver, on_evaluation)
    table = estimate_table(evaluator, fit, seed)
    return {
        "format": FORMAT,
        "campaign": campaign.name,
        "device": campaign.device,
        "parameters": [asdict(p) for p in table.parameters],
        "correlation": table.correlation.tolist(),
        "condition_number": table.condition_number,
        "mean_square": 1.0 + fit.excess / evaluator.count,
        "contact_starts": [
            {
                "run": s.run,
                "stiffness": s.consistent.stiffness,
                "damping": s.consistent.damping,
                "printed_stiffness": s.printed.stiffness,
                "printed_damping": s.printed.damping,
            }
            for s in starts
        ],
        "solver": report.solver,
        "evaluations": report.evaluations,
        "success": report.success,
        "seed": seed,
        "scenario": named.describe(twin.scenario),
        "choice": choice.describe(),
    }
