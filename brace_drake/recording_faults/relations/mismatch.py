"""How far recorded commands are from what the controller makes of the readings.

The floor is simulated: a noisy twin's recording put through the same law, as
readings between samples are not known and their noise is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import Device
from brace_drake.identification.noise_floor import (
    NoiseFloor,
    estimate_floor,
    on_grid,
    written_quantum,
)
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.channels import desired_channels
from brace_drake.recording_faults.statistics import (
    largest_mean_square,
    quantum_of,
)

# Part of an output's own scatter that the law may be off: readings between
# samples are not known, and where pads lose touch a spline is not exact.
_LAW_ERROR = 2e-3
# Noisy replays of a run, and runs that are replayed of each kind.
_REPLICATES, _MODELS = 3, 2


@dataclass(frozen=True)
class Mismatch:
    """Mean squares, in floors, of a run's outputs against the law.

    Attributes:
        squares: Of each output (n,), NaN where it was not recorded.
        threshold: Of each, what noise and the law's own error stay below.
        weighted: Residual over its floor, all outputs (rows,).
    """

    squares: np.ndarray
    threshold: np.ndarray
    weighted: np.ndarray

    @property
    def is_sound(self) -> bool:
        return not bool(np.any(self.squares > self.threshold))

    @property
    def total(self) -> float:
        """Mean square over the outputs."""
        return float(np.nanmean(self.squares))


class LawChecker:
    """Holds recorded runs to the control law of their device.

    Args:
        device: With a control law.
        runs: Of the campaign; the floors are of twins of some of them.
        seed: Of the noise.
    """

    def __init__(self, device: Device, runs: Sequence[Run], seed: int = 0):
        self.law, self._twin = device.control_law, device.twin.coarse()
        self._rate, self._seed = device.rate, seed
        self.runs = tuple(runs)

    @cached_property
    def floors(self) -> dict[bool, NoiseFloor]:
        """Floors of the outputs, with and without contact."""
        found = {}
        for contact in (False, True):
            mine = [r for r in self.runs if r.contact == contact]
            mine.sort(key=lambda r: -_travel(r))
            noise = [n for r in mine[:_MODELS] for n in self.noise(r)]
            if noise:
                rows = min(len(n) for n in noise)
                cut = np.array([_mirrored(n[:rows]) for n in noise])
                quantum = np.zeros(cut.shape[2])
                found[contact] = estimate_floor(cut, self._rate, quantum)
        return found

    def noise(self, run: Run) -> list[np.ndarray]:
        """Residuals of the law in noisy replays (N, n), without effects and of
        the nominal subject; none where the twin breaks down.
        """
        twin, found = self._twin, []
        subject = np.array([p.nominal for p in twin.subject])
        measured = twin.measured(run)
        grid = written_quantum(measured, np.zeros_like(measured))
        for k in range(_REPLICATES):
            generator = np.random.default_rng([self._seed, 41, k])
            motion = twin.motion(_before_rounding(run, generator))
            try:
                x = twin.simulate(motion, subject, (), generator)
            except BraceError:
                return []
            columns = dict(zip(twin.channels, on_grid(x, grid).T, strict=True))
            copy = with_channels(run, {**run.channels, **columns})
            found.append(self.residual(copy))
        return found

    def residual(self, run: Run) -> np.ndarray:
        """Recorded less recomputed outputs (N, n)."""
        return run.stack(self.law.outputs) - self.law.recompute(run)

    def judge(self, run: Run) -> Mismatch | None:
        """A run's mismatch; None where the law tells nothing of it."""
        try:
            return self.weigh(run, self.residual(run))
        except (BraceError, ValueError, np.linalg.LinAlgError):
            return None

    def weigh(self, run: Run, residual: np.ndarray) -> Mismatch | None:
        """A residual (N, n) in units of the run's floor."""
        floor = self.floors.get(run.contact)
        has = run.has(self.law.outputs)
        if floor is None or not has.any() or not np.isfinite(residual).all():
            return None
        count = len(residual)
        mirrored = _mirrored(residual)
        weights = floor.weights(len(mirrored), self._rate) * has
        transform = np.fft.rfft(mirrored, axis=0) * weights
        squares = np.sum(np.abs(transform) ** 2, axis=0) / len(mirrored)
        squares = np.where(has, squares, np.nan)
        tests = len(self.runs) * len(squares)
        spread = np.std(run.stack(self.law.outputs), axis=0)
        error = _LAW_ERROR * spread / np.maximum(floor.rms, 1e-300)
        threshold = largest_mean_square(count, tests) + error**2
        flat = np.concatenate([transform.real.ravel(), transform.imag.ravel()])
        return Mismatch(squares, threshold, flat)


def _mirrored(series: np.ndarray) -> np.ndarray:
    """A series (N, n) followed by its mirror image: what an integrator makes
    of noise ends elsewhere than it began, and a Fourier transform would take
    that for a jump.
    """
    return np.concatenate([series, series[::-1]])


def with_channels(run: Run, columns: Mapping[str, np.ndarray]) -> Run:
    """A run with other columns."""
    return replace(run, channels=dict(columns))


def _travel(run: Run) -> float:
    """What a run is asked to move."""
    moved = [float(np.ptp(run.channels[n])) for n in desired_channels(run)]
    return max(moved, default=0.0)


def _before_rounding(run: Run, generator: np.random.Generator) -> Run:
    """A run with references as they may have been before they were written."""
    columns = dict(run.channels)
    for name in desired_channels(run):
        step = quantum_of(columns[name])
        size = len(columns[name])
        moving = np.gradient(columns[name]) != 0.0
        jitter = step * (generator.random(size) - 0.5) * moving
        columns[name] = columns[name] + jitter
    return with_channels(run, columns)
