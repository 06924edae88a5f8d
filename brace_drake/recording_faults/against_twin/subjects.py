"""Runs of another subject: one fits some, another the rest, none both."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.recording_faults.against_twin.misfit import (
    SubjectFit,
    fit_subject_to,
    make_evaluator,
)
from brace_drake.recording_faults.finding import Finding
from brace_drake.recording_faults.library.runs import other_subject

# Misfit that two subjects may leave, and by how many times less than one.
NEAR, TIMES = 0.5, 10.0
# More runs are not divided in all ways.
_MOST_RUNS = 12


@dataclass(frozen=True)
class Division:
    """Runs in two groups, each with a subject of its own.

    Attributes:
        others: Places of the runs in the smaller group.
        one, two: Misfit with one subject, and with two.
        first, second: Their subjects.
    """

    others: tuple[int, ...]
    one: float
    two: float
    first: np.ndarray
    second: np.ndarray


def fit_runs_alone(
    device: Device,
    runs: Sequence[PreparedRun],
    subject: np.ndarray,
    uses: Sequence[Use],
    jobs,
) -> list[SubjectFit] | None:
    """Each run's own subject; None where the twin breaks down on one."""
    fits = []
    for prepared in runs:
        evaluator = make_evaluator(device, [prepared], subject, uses, jobs)
        fit = fit_subject_to(evaluator, subject, uses)
        if fit is None:
            return None
        fits.append(fit)
    return fits


def divide(fits: Sequence[SubjectFit]) -> Division | None:
    """The division into two groups that leaves least, by each run's quadratic.

    Each run's sum of squares near its own best z_i is c_i + |J_i (z - z_i)|^2,
    so that groups of runs are linear least squares.
    """
    count = len(fits)
    if not 2 <= count <= _MOST_RUNS:
        return None
    normal = [f.solution.jacobian.T @ f.solution.jacobian for f in fits]
    total = sum(f.evaluator.count for f in fits)
    level = sum(f.level * f.evaluator.count for f in fits) / total
    own = sum(float(f.solution.residual @ f.solution.residual) for f in fits)

    def together(group):
        """Best z of a group and what it costs beyond each run's own."""
        H = sum(normal[i] for i in group)
        b = sum(normal[i] @ fits[i].scaled for i in group)
        ridge = 1e-9 * np.trace(H) / len(H)
        # Of runs that show nothing of the subject it is singular.
        z, *_ = np.linalg.lstsq(H + ridge * np.eye(len(H)), b, rcond=None)
        away = [z - fits[i].scaled for i in group]
        cost = sum(
            float(d @ normal[i] @ d) for d, i in zip(away, group, strict=True)
        )
        return z, cost

    everyone = tuple(range(count))
    cost_all = together(everyone)[1]
    best = None
    for size in range(1, count // 2 + 1):
        for others in itertools.combinations(everyone, size):
            rest = tuple(i for i in everyone if i not in others)
            (first, a), (second, b) = together(rest), together(others)
            if best is None or a + b < best[0]:
                best = (a + b, others, first, second)
    cost, others, first, second = best
    return Division(
        others,
        (own + cost_all) / total - level,
        (own + cost) / total - level,
        first,
        second,
    )


def find_other_subjects(
    device: Device,
    runs: Sequence[PreparedRun],
    subject: np.ndarray,
    uses: Sequence[Use],
    jobs,
) -> list[Finding]:
    """Whether some of the fit runs are another subject's."""
    mine = [p for p in runs if p.run.contact]
    if len(mine) < 2:
        return []
    fits = fit_runs_alone(device, mine, subject, uses, jobs)
    found = divide(fits) if fits else None
    if found is None or found.two > NEAR:
        return []
    if found.one < TIMES * max(found.two, 0.05):
        return []
    # The quadratics are of small differences: the groups are fitted anew.
    units = np.array([p.unit_step for p in device.twin.subject])
    groups = (
        [p for i, p in enumerate(mine) if i not in found.others],
        [mine[i] for i in found.others],
    )
    anew = []
    for group, z in zip(groups, (found.first, found.second), strict=True):
        evaluator = make_evaluator(device, group, z * units, uses, jobs)
        anew.append(fit_subject_to(evaluator, z * units, uses))
    if any(f is None or f.misfit > 2.0 * NEAR for f in anew):
        return []
    return [_finding(device, groups[1], anew[0], anew[1], found)]


def _finding(device, others, first, second, found: Division) -> Finding:
    names = [p.name for p in device.twin.subject]
    # Of what is above zero in any subject.
    size = [p.lower > 0.0 for p in device.twin.subject]
    ratio = np.where(size, second.subject, 1.0)
    ratio = ratio / np.where(size, first.subject, 1.0)
    k = int(np.argmax(np.abs(np.log(ratio))))
    detail = (
        f"one subject leaves a misfit of {found.one:.3g} noise variances, two"
        f" leave {max(found.two, 0.0):.2g}; {names[k]} is {ratio[k]:.3g} times"
        " the others'"
    )
    values = dict(zip(names, map(float, second.subject), strict=True))
    return Finding(
        other_subject.CARD,
        tuple(p.run.file for p in others),
        (),
        values,
        0.95,
        detail,
        before=1.0 + found.one,
        after=1.0 + found.two,
    )
