"""Block residual tests: each block fed its recorded inputs.

A block whose recorded inputs lead to its recorded outputs, as near as they do
in noisy replays of the twin itself, is acquitted: the gap is elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from brace_drake.devices.declaration import BlockTest
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.noise_floor import on_grid, written_quantum

# Machines, noise and tolerances drawn, that a block is compared with.
NUM_MACHINES = 6
# A block's residual may exceed its own noise this much, and three times the
# spread between replicates, before it is accused.
_TOLERANCE = 1.15
# Of a block's own parameters: relative change of a difference, most trials.
_NUDGE, _TRIES = 1e-3, 12


def run_block_tests(
    evaluator: Evaluator,
    tests: Sequence[BlockTest],
    fit: CandidateFit,
    seed: int,
    drawn: Sequence[Sequence[Use]] = (),
) -> list[dict]:
    """Rows with the residual of each block against that of noisy replays.

    What a block has of the subject is fitted to its own inputs and outputs:
    the closed loop's fit bends it to cover what other blocks do.

    Args:
        evaluator: Over the runs to look at.
        tests: The device's, in the order of the signal.
        fit: Whose subject, without effects, the blocks set out from.
        seed: Of the replays.
        drawn: Machines within their tolerances, one for each noisy replay; by
            default all have the twin's numbers.
    """
    machines = drawn or [()] * NUM_MACHINES

    def take_part(prepared):
        """The recording, then as noisy replays would have been written."""
        written = evaluator.twin.written(prepared.run)
        grid = written_quantum(written, evaluator.twin.reading_steps)
        replays = [
            evaluator.twin.simulate(
                prepared.motion,
                fit.subject,
                uses,
                np.random.default_rng([seed, 29, prepared.seed, i]),
            )
            for i, uses in enumerate(machines)
        ]
        return [prepared.measured, *(on_grid(r, grid) for r in replays)]

    found = evaluator.map(take_part, [(p,) for p in evaluator.prepared])
    takes = list(zip(*found, strict=True))
    powers = evaluator.map(
        lambda test, take: _power(test, evaluator, take, fit.subject),
        [(test, take) for test in tests for take in takes],
    )
    powers = np.reshape(powers, (len(tests), len(takes)))
    rows = []
    for test, (recorded, *replicates) in zip(tests, powers, strict=True):
        if np.isnan(recorded):
            continue
        noise = np.mean(replicates)
        threshold = _TOLERANCE
        if noise > 0.0:
            threshold += 3.0 * float(np.std(np.sqrt(replicates / noise)))
        ratio = float(np.sqrt(recorded / noise)) if noise > 0.0 else np.inf
        rows.append(
            {
                "block": test.block,
                "input": test.given,
                "output": test.found,
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
    evaluator: Evaluator, tests: Sequence[BlockTest], rows: Sequence[dict]
) -> list[str]:
    """Sentences on what lies between recorded channels and cannot be divided.

    Args:
        evaluator: Over the runs that were looked at.
        tests: Of the device.
        rows: From `run_block_tests`.
    """
    checked = {row["block"] for row in rows}
    segments: dict[tuple[str, ...], list[str]] = {}
    for test in tests:
        has = [p.run.has(test.needs) for p in evaluator.prepared]
        lacks = np.array(test.needs)[~np.any(has, axis=0)]
        if test.block not in checked and len(lacks):
            segments.setdefault(tuple(lacks), []).append(test.block)
    return [
        f"{' and '.join(blocks)}: not checked by"
        f" {'themselves' if len(blocks) > 1 else 'itself'}, as"
        f" {', '.join(lacks)} {'were' if len(lacks) > 1 else 'was'} not"
        " recorded"
        + ("; what errs there cannot be divided" if len(blocks) > 1 else "")
        for lacks, blocks in segments.items()
    ]


def _power(
    test: BlockTest, evaluator: Evaluator, take: Sequence[np.ndarray], subject
) -> float:
    """Mean square over runs that a block leaves at its best parameters.

    NaN where no run says anything about it.
    """
    parts = [
        test.residual(p, x)
        for p, x in zip(evaluator.prepared, take, strict=True)
        if p.run.has(test.needs).all()
    ]
    # A run may say nothing, and one without a sample of the block neither.
    parts = [p for p in parts if p is not None and len(p(subject))]
    if not parts:
        return np.nan

    known = evaluator.twin.subject
    own = [
        i for i, p in enumerate(known) if p.name in test.own and not p.is_fixed
    ]
    parameters = [known[i] for i in own]
    units = np.array([p.unit_step for p in parameters])

    def residual(z):
        values = subject.copy()
        values[own] = z * units
        found = [part(values).ravel() for part in parts]
        return np.concatenate([r / np.sqrt(len(r) * len(found)) for r in found])

    base = residual(subject[own] / units)
    if not own:
        return float(base @ base)

    low = np.array([p.lower for p in parameters]) / units
    high = np.array([p.upper for p in parameters]) / units
    start = np.clip(subject[own] / units, low, high)
    best = least_squares(
        residual, start, bounds=(low, high), diff_step=_NUDGE, max_nfev=_TRIES
    )
    return float(min(2.0 * best.cost, base @ base))
