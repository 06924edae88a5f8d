"""Recording faults beside effects: which of the two explains a campaign."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit, fit_effects
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording.recording import Campaign
from brace_drake.recording_faults.against_twin.few_runs import find_few_runs
from brace_drake.recording_faults.against_twin.late import find_late_readings
from brace_drake.recording_faults.against_twin.misfit import fit_subject_to
from brace_drake.recording_faults.against_twin.odd_runs import Maker
from brace_drake.recording_faults.against_twin.refits import find_undone
from brace_drake.recording_faults.against_twin.refitter import Refitter
from brace_drake.recording_faults.against_twin.sensors import (
    find_sensor_faults,
)
from brace_drake.recording_faults.against_twin.subjects import (
    find_other_subjects,
)
from brace_drake.recording_faults.against_twin.validation import (
    find_validation_faults,
)
from brace_drake.recording_faults.finding import Finding

# Misfit below which the fit runs show nothing that a fault could explain.
_NOTHING = 0.5


def find_recording_faults(
    device: Device,
    campaign: Campaign,
    maker: Maker,
    fit_runs: Sequence[PreparedRun],
    validation: Sequence[PreparedRun],
    fit: CandidateFit,
    jobs=1,
    is_right: bool = False,
    seed: int = 0,
) -> list[Finding]:
    """Faults that the twin shows and no effect explains.

    The fit is the best that the effects have come to, the nominal one where
    none was found. What it explains down to what a right twin leaves is the
    machine's.

    Args:
        device: Of the campaign.
        campaign: As loaded.
        maker: Of the device of some of the runs.
        fit_runs, validation: As prepared for fit and comparison.
        fit: The best explanation by subject and effects.
        jobs: As of `Evaluator`.
        is_right: Whether the fit is known to leave no more than a right twin.
        seed: Of noise floors.
    """
    # Numbers within their tolerances are no fault of the recording.
    subject, uses = fit.subject, (*fit.uses, *fit.within)
    # What each run has of its own would have to be estimated anew.
    if fit.has_run_parameters:
        return []
    is_lawless = device.control_law is None
    if not (device.takes_subjects or is_lawless):
        return []
    evaluator = Evaluator(device.twin, fit_runs, jobs)
    evaluator.tolerances = fit.tolerances
    own = fit_subject_to(evaluator, subject, uses)
    if own is None:
        return []
    beside = device, fit_runs, own, uses, jobs
    few = find_few_runs(*beside)
    found = few.faults()
    if found:
        return found
    if own.misfit > _NOTHING and not is_right and is_lawless:
        every = Refitter(device, (), fit_runs, subject, uses, jobs)
        found = find_undone(every, validation, campaign, maker, seed)
        return found or find_validation_faults(
            device, fit_runs, validation, own.subject, uses, jobs
        )
    if own.misfit > _NOTHING and not is_right:
        start = device, fit_runs, subject, uses, jobs
        return (
            find_sensor_faults(*start)
            or find_other_subjects(*start)
            or few.contradictions()
        )
    found = [] if is_lawless else find_late_readings(*beside)
    if found:
        return found
    return find_validation_faults(
        device, fit_runs, validation, own.subject, uses, jobs
    )


def judge_campaign(
    campaign: Campaign,
    device: Device,
    effects: Sequence[Effect] = (),
    jobs=1,
    seed: int = 0,
    maker: Maker | None = None,
) -> tuple[list[Finding], float]:
    """Faults beside given effects alone, and the misfit that these leave.

    Args:
        campaign: That the check has passed.
        device: Of it.
        effects: That the machine is known to have, fitted with the subject.
        jobs: As of `Evaluator`.
        seed: Of the noise floor.
        maker: As of `find_recording_faults`; None: the device is as it is, and
            has no effects.
    """
    twin, rate = device.twin, campaign.rate_hz
    usual = np.array([p.nominal for p in twin.subject])
    floors, _ = estimate_floors(twin, campaign, usual, seed)
    runs = prepare_runs(twin, campaign.split("fit"), floors, rate, seed)
    new = campaign.split("validation")
    held_out = prepare_runs(twin, new, floors, rate, seed + 1000)
    evaluator = Evaluator(twin, runs, jobs)
    fit = fit_nominal(evaluator, device.tolerances())
    if effects:
        starts = [e.starts()[0].astype(float) for e in effects]
        fit = fit_effects(evaluator, effects, starts)
    found = find_recording_faults(
        device,
        campaign,
        maker or Maker(lambda part: device, _nominal),
        runs,
        held_out,
        fit,
        jobs,
        seed=seed,
    )
    return found, fit.excess / evaluator.count


def _nominal(device: Device, runs: Sequence[PreparedRun]) -> CandidateFit:
    return fit_nominal(Evaluator(device.twin, runs, 1), device.tolerances())
