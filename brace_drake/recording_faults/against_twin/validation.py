"""Validation runs that contradict what the fit runs say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.recording_faults.against_twin.misfit import (
    fit_subject_to,
    make_evaluator,
    misfit_of,
)
from brace_drake.recording_faults.against_twin.refits import explain_runs
from brace_drake.recording_faults.against_twin.sensors import (
    find_sensor_faults,
)
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.runs import (
    contradiction,
    other_subject,
)

# A run contradicts the fit from this misfit on, and as many times that of the
# worst fit run.
_MISFIT, _TIMES = 1.0, 10.0
# A fault has explained it when so little is left.
_NEAR, _LEFT = 0.5, 0.1


def find_validation_faults(
    device: Device,
    fit_runs: Sequence[PreparedRun],
    validation: Sequence[PreparedRun],
    subject: np.ndarray,
    uses: Sequence[Use],
    jobs,
) -> list[Finding]:
    """Validation runs that are not of the machine and subject of the fit.

    Args:
        device: Of the campaign.
        fit_runs, validation: As prepared.
        subject, uses: Of the fit, on the fit runs.
        jobs: As of `Evaluator`.
    """
    found = [(p, _misfit(device, [p], subject, uses, jobs)) for p in validation]
    bad = [(p, m) for p, m in found if m > _MISFIT]
    if not bad:
        return []
    level = max(_misfit(device, [p], subject, uses, jobs) for p in fit_runs)
    bad = [(p, m) for p, m in bad if m > _TIMES * level]
    if not bad:
        return []
    runs = [p for p, _ in bad]
    if device.control_law is None:
        return [
            f
            for p in runs
            for f in explain_runs(device, fit_runs, [p], subject, uses, jobs)
        ]
    worst = max(m for _, m in bad)
    sensors = find_sensor_faults(device, runs, subject, uses, jobs)
    if sensors:
        return sensors
    return _other_subject(device, runs, worst, subject, uses, jobs)


def _other_subject(device, runs, worst, subject, uses, jobs) -> list[Finding]:
    """Another subject where one fits the runs, else a contradiction."""
    files = tuple(p.run.file for p in runs)
    seen = (
        f"the fit of the other runs leaves a misfit of {worst:.3g} noise"
        " variances in them"
    )
    if any(p.run.contact for p in runs):
        evaluator = make_evaluator(device, runs, subject, uses, jobs)
        fit = fit_subject_to(evaluator, subject, uses)
        if fit is not None and fit.misfit < max(_NEAR, _LEFT**2 * worst):
            names = [p.name for p in device.twin.subject]
            values = dict(zip(names, map(float, fit.subject), strict=True))
            return [
                Finding(
                    other_subject.CARD,
                    files,
                    (),
                    values,
                    0.93,
                    f"{seen}, another subject {max(fit.misfit, 0.0):.2g}",
                    before=1.0 + worst,
                    after=1.0 + fit.misfit,
                )
            ]
    return [
        Finding(
            contradiction.CARD,
            files,
            (),
            {},
            0.8,
            seen,
            severity="warning",
            before=1.0 + worst,
        )
    ]


def _misfit(device, runs, subject, uses, jobs) -> float:
    """Misfit beside tolerances; without them where it is small already, as
    they only take from it.
    """
    found = misfit_of(Evaluator(device.twin, runs, jobs), subject, uses)
    if found is not None and found > _MISFIT:
        evaluator = make_evaluator(device, runs, subject, uses, jobs)
        found = misfit_of(evaluator, subject, uses)
    return np.inf if found is None else found
