"""The substitution ladder: each block fed its recorded inputs.

A block whose recorded inputs lead to its recorded outputs, as near as they do
in noisy replays of the twin itself, is acquitted: the gap is elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.noise_floor import on_grid, written_quantum

_REPLICATES = 4
# A block's residual may exceed its own noise this much, and three times the
# spread between replicates, before it is accused.
_TOLERANCE = 1.15
# Of a block's own parameters: relative change of a difference, most trials.
_NUDGE, _TRIES = 1e-3, 12


Residual = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Rung:
    """One block of the ladder.

    Attributes:
        block: Its name.
        given, found: What it is fed and what is compared, in words.
        residual: From (prepared run, recording (N, C)) to the residual (M,)
            as a function of the subject's values, or None where the run says
            nothing about it.
        needs: Channels without which a run says nothing about it.
        own: Names of the subject's parameters that are the block's.
    """

    block: str
    given: str
    found: str
    residual: Callable[[PreparedRun, np.ndarray], Residual | None]
    needs: tuple[str, ...] = ()
    own: tuple[str, ...] = ()


def climb(
    evaluator: Evaluator,
    rungs: Sequence[Rung],
    fit: CandidateFit,
    seed: int,
) -> list[dict]:
    """Residual of each block against that of noisy replays of the twin.

    What a block has of the subject is fitted to its own inputs and outputs:
    the closed loop's fit bends it to cover what other blocks do.

    Args:
        evaluator: Over the runs to look at.
        rungs: The device's blocks in the order of the signal.
        fit: Whose subject, without effects, the blocks set out from.
        seed: Of the replays.
    """

    def recordings_of(prepared):
        recordings = [prepared.measured]
        grid = written_quantum(
            prepared.measured, np.zeros_like(prepared.measured)
        )
        for i in range(_REPLICATES):
            generator = np.random.default_rng([seed, 29, prepared.seed, i])
            replay = evaluator.twin.simulate(
                prepared.motion, fit.subject, (), generator
            )
            recordings.append(on_grid(replay, grid))
        return recordings

    found = evaluator.map(recordings_of, [(p,) for p in evaluator.prepared])
    takes = list(zip(*found, strict=True))
    tasks = [(rung, take) for rung in rungs for take in takes]

    def power(rung, take):
        return _power(rung, evaluator, take, fit.subject)

    powers = np.array(evaluator.map(power, tasks)).reshape(len(rungs), -1)
    rows = []
    for rung, (recorded, *replicates) in zip(rungs, powers, strict=True):
        if np.isnan(recorded):
            continue
        noise = np.mean(replicates)
        threshold = _TOLERANCE
        if noise > 0.0:
            threshold += 3.0 * float(np.std(np.sqrt(replicates / noise)))
        ratio = float(np.sqrt(recorded / noise)) if noise > 0.0 else np.inf
        rows.append(
            {
                "block": rung.block,
                "input": rung.given,
                "output": rung.found,
                "normalised_rms": ratio,
                "threshold": threshold,
                "acquitted": bool(ratio <= threshold),
            }
        )
    excess = np.array([max(0.0, r["normalised_rms"] ** 2 - 1.0) for r in rows])
    accused = np.array([not r["acquitted"] for r in rows])
    excess = np.where(accused, excess, 0.0)
    total = excess.sum()
    for row, value in zip(rows, excess, strict=True):
        row["share"] = float(value / total) if total > 0.0 else 0.0
    return rows


def describe_unchecked(
    evaluator: Evaluator, rungs: Sequence[Rung], rows: Sequence[dict]
) -> list[str]:
    """Sentences on what lies between recorded channels and cannot be divided.

    Args:
        evaluator: Over the runs that were looked at.
        rungs: Of the device.
        rows: From `climb`.
    """
    checked = {row["block"] for row in rows}
    segments: dict[tuple[str, ...], list[str]] = {}
    for rung in rungs:
        has = [p.run.has(rung.needs) for p in evaluator.prepared]
        lacks = np.array(rung.needs)[~np.any(has, axis=0)]
        if rung.block not in checked and len(lacks):
            segments.setdefault(tuple(lacks), []).append(rung.block)
    return [
        f"{' and '.join(blocks)}: not checked by"
        f" {'themselves' if len(blocks) > 1 else 'itself'}, as"
        f" {', '.join(lacks)} {'were' if len(lacks) > 1 else 'was'} not"
        " recorded"
        + ("; what errs there cannot be divided" if len(blocks) > 1 else "")
        for lacks, blocks in segments.items()
    ]


def holds_at_rest(ladder: Sequence[dict]) -> bool | None:
    """Whether the leg lengths at rest are as they should be; None where the
    device has no such lengths.
    """
    rows = [r for r in ladder if r["block"] == "mechanism"]
    return all(r["acquitted"] for r in rows) if rows else None


def _power(
    rung: Rung, evaluator: Evaluator, take: Sequence[np.ndarray], subject
) -> float:
    """Mean square over runs that a block leaves at its best parameters.

    NaN where no run says anything about it.
    """
    parts = [
        rung.residual(p, x)
        for p, x in zip(evaluator.prepared, take, strict=True)
        if p.run.has(rung.needs).all()
    ]
    # A run may say nothing, and one without a sample of the block neither.
    parts = [p for p in parts if p is not None and len(p(subject))]
    if not parts:
        return np.nan

    def residual(values):
        found = [part(values).ravel() for part in parts]
        return np.concatenate([r / np.sqrt(len(r) * len(found)) for r in found])

    base = residual(subject)
    own = [
        i for i, p in enumerate(evaluator.twin.subject) if p.name in rung.own
    ]
    if not own:
        return float(base @ base)
    parameters = [evaluator.twin.subject[i] for i in own]
    units = np.array([p.unit_step for p in parameters])

    def scaled(z):
        values = subject.copy()
        values[own] = z * units
        return residual(values)

    low = np.array([p.lower for p in parameters]) / units
    high = np.array([p.upper for p in parameters]) / units
    start = np.clip(subject[own] / units, low, high)
    best = least_squares(
        scaled, start, bounds=(low, high), diff_step=_NUDGE, max_nfev=_TRIES
    )
    return float(min(2.0 * best.cost, base @ base))
