"""Runs that have not been recorded yet, ready for the twin's predictions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from brace_drake.devices.replays import (
    is_dithered,
    replay_each,
    uses_in_run,
)
from brace_drake.devices.twin import Request
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.noise_floor import NoiseFloor, estimate_floor
from brace_drake.identification.prepare import noise_replicates, prepare_run
from brace_drake.recording.recording import Run

_REPLICATES = 12
# Noisy replays averaged where noise acts as a dither.
_DITHERS = 2
# Of differences by the subject, in its units.
_STEP = 1e-2
# Of differences by an effect's parameters, relative.
_EFFECT_STEP = 0.05


def planned_runs(
    twin,
    runs: Sequence[Run],
    floors: Mapping[bool, NoiseFloor],
    rate: float,
    seed: int,
) -> list[PreparedRun]:
    """Runs of a reference alone, weighted as recordings of them would be.

    Args:
        twin: Of the bench.
        runs: With a reference, evenly sampled.
        floors: By contact.
        rate: Of the samples, Hz.
        seed: Of the dithers.
    """
    return [
        prepare_run(twin, run, _unrecorded(twin, run), floors, rate, seed, i)
        for i, run in enumerate(runs)
    ]


def _unrecorded(twin, run: Run) -> np.ndarray:
    return np.zeros((len(run.time_s), len(twin.channels)))


def planned_floors(
    twin, runs: Sequence[Run], subject: np.ndarray, rate: float, seed: int
) -> dict[bool, NoiseFloor]:
    """Floors by contact from the twin's own noise, one run of each kind."""
    floors = {}
    for run in runs:
        if run.contact not in floors:
            seeds = [[seed, 7, k] for k in range(_REPLICATES)]
            motion = twin.motion(run)
            noise = noise_replicates(twin, motion, subject, (), seeds)
            floors[run.contact] = estimate_floor(noise, rate)
    return floors


def predict(
    evaluator: Evaluator,
    points: Sequence[tuple[np.ndarray, Sequence[Use]]],
    dithered: bool | None = None,
) -> list[list[np.ndarray | None]]:
    """Weighted predictions at several points, run by run.

    What single runs have of their own, such as the phase of a breath, is 0.
    Where noise acts as a dither to one of the points, all are averaged over
    the same noisy replays, so that their differences hold little of it.

    Args:
        evaluator: Over planned runs.
        points: Subject and effects.
        dithered: Whether to average; None: where one of the points needs it.

    Returns:
        For each point the vector of each run; None where the twin broke down.
    """
    twin = evaluator.twin.coarse()
    points = [
        (s, [(e, v[: len(e.parameters)]) for e, v in uses])
        for s, uses in points
    ]
    if dithered is None:
        dithered = any(is_dithered(twin, u) for _, u in points)

    noisy = [_DITHERS if dithered else 0] * len(points)
    each = [(subject, uses_in_run(uses, 0)) for subject, uses in points]

    def of_run(p):
        requests = [Request(p.motion, s, u, (p.seed,)) for s, u in each]
        replays = replay_each(twin, requests, noisy)
        return [None if x is None else p.weigh(x) for x in replays]

    parts = evaluator.map(of_run, [(p,) for p in evaluator.prepared])
    return [list(point) for point in zip(*parts, strict=True)]


def subject_columns(
    evaluator: Evaluator, subject: np.ndarray, uses: Sequence[Use] = ()
) -> list[np.ndarray | None]:
    """Sensitivities to the subject's parameters, run by run (rows, n).

    Forward differences, each parameter counted in its `unit_step`; None where
    the twin broke down.
    """
    known = evaluator.twin.subject
    units = [0.0 if p.is_fixed else p.unit_step for p in known]
    points = [(subject, uses)]
    for i, unit in enumerate(units):
        moved = subject.copy()
        moved[i] += _STEP * unit
        points.append((moved, uses))
    return _differences(evaluator, points, [_STEP] * len(units))


def effect_columns(
    evaluator: Evaluator, subject: np.ndarray, uses: Sequence[Use]
) -> list[np.ndarray | None]:
    """Sensitivities to the effects' continuous parameters, run by run.

    Forward differences (rows, n), backward ones at an upper limit; None where
    the twin broke down. Effects of dozens of parameters have none.
    """
    points, steps = [(subject, uses)], []
    for k, (effect, values) in enumerate(uses):
        if effect.is_flexible:
            continue
        for i in np.flatnonzero(effect.is_continuous):
            parameter, moved = effect.parameters[i], np.array(values)
            step = _EFFECT_STEP * (abs(moved[i]) or parameter.typical)
            if moved[i] + step > parameter.upper:
                step = -step
            moved[i] += step
            changed = [*uses[:k], (effect, moved), *uses[k + 1 :]]
            points.append((subject, changed))
            steps.append(step)
    return _differences(evaluator, points, steps)


def _differences(evaluator, points, steps) -> list[np.ndarray | None]:
    """Changes from the first point to the others by their steps, per run."""
    columns = []
    for start, *ends in zip(*predict(evaluator, points), strict=True):
        if start is None or any(end is None for end in ends):
            columns.append(None)
            continue
        found = [(e - start) / s for e, s in zip(ends, steps, strict=True)]
        columns.append(
            np.column_stack(found) if found else np.zeros((len(start), 0))
        )
    return columns
