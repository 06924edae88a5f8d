"""Weighted residuals of a twin over runs, and their sensitivities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from brace_drake.campaign.recording import Run
from brace_drake.effects.stack import Use
from brace_drake.errors import BraceError
from brace_drake.gap.floor import NoiseFloor


@dataclass(frozen=True)
class PreparedRun:
    """A run ready for comparison.

    Attributes:
        run: The recording.
        motion: What the twin takes of it.
        measured: Recorded channels (N, C).
        weights: Of the transform, see `NoiseFloor.weights`; 0 where a channel
            carries no information.
        floor: Noise floor of this kind of run.
    """

    run: Run
    motion: object
    measured: np.ndarray
    weights: np.ndarray
    floor: NoiseFloor

    def weigh(self, residual: np.ndarray) -> np.ndarray:
        """Residual (N, C) as a vector of unit variance for pure noise."""
        transform = np.fft.rfft(residual, axis=0) * self.weights
        used = self.weights[1] > 0.0
        transform = transform[:, used]
        return np.concatenate(
            [transform.real.ravel(), transform[1:].imag.ravel()]
        )


class Evaluator:
    """Evaluates a twin on runs, in parallel threads.

    The compiled rollout releases the interpreter lock, so that threads scale
    with cores and share one compiled twin.
    """

    def __init__(self, twin, prepared: Sequence[PreparedRun], jobs: int):
        self.twin = twin
        self.prepared = list(prepared)
        self._pool = ThreadPoolExecutor(max_workers=max(1, jobs))

    def map(self, function: Callable, tasks: Sequence) -> list:
        """Results of `function(*task)` in order."""
        return list(self._pool.map(lambda task: function(*task), tasks))

    def residual_of(
        self, prepared: PreparedRun, subject: np.ndarray, uses: Sequence[Use]
    ) -> np.ndarray:
        """Measured minus simulated (N, C)."""
        simulated = self.twin.simulate(prepared.motion, subject, uses)
        return prepared.measured - simulated

    def _weighted(self, prepared, subject, uses) -> np.ndarray:
        return prepared.weigh(self.residual_of(prepared, subject, uses))

    def residual(
        self, subject: np.ndarray, uses: Sequence[Use] = ()
    ) -> np.ndarray:
        """Weighted residuals of all runs, one vector."""
        tasks = [(p, subject, uses) for p in self.prepared]
        return np.concatenate(self.map(self._weighted, tasks))

    def residuals(
        self, points: Sequence[tuple[np.ndarray, Sequence[Use]]]
    ) -> list[np.ndarray | None]:
        """Weighted residuals at several points at once.

        None where the twin broke down.
        """
        tasks = [(p, s, u) for s, u in points for p in self.prepared]
        parts = self.map(self._guarded, tasks)
        size = len(self.prepared)
        chunks = [parts[i : i + size] for i in range(0, len(parts), size)]
        return [
            None if any(p is None for p in chunk) else np.concatenate(chunk)
            for chunk in chunks
        ]

    def _guarded(self, prepared, subject, uses):
        try:
            return self._weighted(prepared, subject, uses)
        except BraceError:
            return None
