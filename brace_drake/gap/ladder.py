"""The substitution ladder: each block fed its recorded inputs.

A block whose recorded inputs lead to its recorded outputs, as near as they do
in noisy replays of the twin itself, is acquitted: the gap is elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.gap.candidates import CandidateFit
from brace_drake.gap.evaluation import Evaluator, PreparedRun
from brace_drake.gap.floor import on_grid, written_quantum

_REPLICATES = 4
# A block's residual may exceed its own noise this much, and three times the
# spread between replicates, before it is accused.
_TOLERANCE = 1.15


@dataclass(frozen=True)
class Rung:
    """One block of the ladder.

    Attributes:
        block: Its name.
        given, found: What it is fed and what is compared, in words.
        residual: From (prepared run, recording (N, C), subject values) to a
            residual (M,), or None where the run says nothing about it.
        needs: Channels without which a run says nothing about it.
    """

    block: str
    given: str
    found: str
    residual: Callable[[PreparedRun, np.ndarray, np.ndarray], np.ndarray | None]
    needs: tuple[str, ...] = ()


def climb(
    evaluator: Evaluator,
    rungs: Sequence[Rung],
    fit: CandidateFit,
    seed: int,
) -> list[dict]:
    """Residual of each block against that of noisy replays of the twin.

    Args:
        evaluator: Over the runs to look at.
        rungs: The device's blocks in the order of the signal.
        fit: Whose subject, without effects, the blocks take.
        seed: Of the replays.
    """

    def powers(prepared):
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
        return [
            [_mean_square(r, prepared, x, fit.subject) for x in recordings]
            for r in rungs
        ]

    found = evaluator.map(powers, [(p,) for p in evaluator.prepared])
    rows = []
    for i, rung in enumerate(rungs):
        pairs = [run[i] for run in found if run[i][0] is not None]
        if not pairs:
            continue
        recorded = np.mean([p[0] for p in pairs])
        replicates = np.mean([p[1:] for p in pairs], axis=0)
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


def _mean_square(rung, prepared, recording, subject):
    if not prepared.run.has(rung.needs).all():
        return None
    residual = rung.residual(prepared, recording, subject)
    return None if residual is None else float(np.mean(residual**2))


def low_pass(signal: np.ndarray, cutoff_hz: float, rate: float) -> np.ndarray:
    """Zero-phase low pass along time by a smooth cut of the spectrum."""
    extended = np.concatenate([signal, signal[::-1]])
    frequency = np.fft.rfftfreq(len(extended), 1.0 / rate)
    taper = 1.0 / (1.0 + (frequency / cutoff_hz) ** 8)
    shape = (-1,) + (1,) * (signal.ndim - 1)
    spectrum = np.fft.rfft(extended, axis=0) * taper.reshape(shape)
    return np.fft.irfft(spectrum, len(extended), axis=0)[: len(signal)]
