"""How far recorded commands are from what the controller makes of the readings.

The floor is simulated: a noisy twin's recording put through the same law, as
readings between samples are not known and their noise is. A machine whose
readings are noisier than the twin's, as on pads that damp more, has a floor
that is higher by as much.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from brace_drake.core.cosine_transform import to_frequency
from brace_drake.core.errors import BraceError
from brace_drake.devices.declaration import Device
from brace_drake.identification.noise_floor import (
    NoiseFloor,
    estimate_floor,
    on_grid,
    quantum_of,
    written_quantum,
)
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.channels import (
    desired_channels,
    is_desired,
)
from brace_drake.recording_faults.statistics import (
    largest_mean_square,
    noise_deviation,
)

# Part of an output's own scatter that the law may be off: readings between
# samples are not known, and where pads lose touch a spline is not exact.
_LAW_ERROR = 2e-3
# Noisy replays of a run, and runs that are replayed of each kind.
_REPLICATES, _MODELS = 3, 2
# Largest square of a rounding error over its mean: (1/2)^2 over 1/12.
_ROUNDED = 3.0
# Variance of a machine's noise over the twin's, at most: what is noisier is no
# reading.
_MOST_NOISE = 10.0


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
            copies = [c for r in mine[:_MODELS] for c in self.replays(r)]
            if copies:
                noise = [self.residual(c) for c in copies]
                rows = min(len(n) for n in noise)
                cut = np.array([n[:rows] for n in noise])
                floor = estimate_floor(cut, self._rate)
                found[contact] = floor.scaled(self._noisier(mine, copies))
        return found

    def _noisier(
        self, runs: Sequence[Run], copies: Sequence[Run]
    ) -> np.ndarray:
        """Variance of noise in recorded readings over that in the twin's, of
        the noisiest that each output answers to (n,): as most runs have it,
        what spoils one run is no part of it. Less than the twin's proves
        nothing, and much more is no noise.
        """
        names = [
            [n for n in own if not is_desired(n)] for own in self.law.by_output
        ]
        ratio = {}
        for name in {n for own in names for n in own}:
            usual = _noise_variance(copies, name)
            ratio[name] = _noise_variance(runs, name) / usual if usual else 1.0
        worst = [max((ratio[n] for n in own), default=1.0) for own in names]
        return np.clip(worst, 1.0, _MOST_NOISE)

    def replays(self, run: Run) -> list[Run]:
        """Noisy replays of a run, without effects and of the nominal subject;
        none where the twin breaks down.
        """
        twin = self._twin
        found: list[Run] = []
        subject = np.array([p.nominal for p in twin.subject])
        measured = twin.measured(run)
        grid = written_quantum(measured, np.zeros(measured.shape[1]))
        for k in range(_REPLICATES):
            generator = np.random.default_rng([self._seed, 41, k])
            motion = twin.motion(_before_rounding(run, generator))
            try:
                x = twin.simulate(motion, subject, (), generator)
            except BraceError:
                return []
            columns = dict(zip(twin.channels, on_grid(x, grid).T, strict=True))
            found.append(with_channels(run, {**run.channels, **columns}))
        return found

    @cached_property
    def _bias(self) -> np.ndarray:
        """Of each output, the largest square of what coarse readings add over
        its mean (n,): while a machine stands, they err by the same part of a
        step all the time.
        """
        coarse = set()
        for run in self.runs:
            names = [n for n in run.channels if not is_desired(n)]
            columns = run.stack(names)
            steps = written_quantum(columns, np.zeros(len(names)))
            for name, step, x in zip(names, steps, columns.T, strict=True):
                noise = noise_deviation(x)
                coarse |= {name} if step > noise else set()
        return np.array(
            [_ROUNDED if coarse & set(n) else 1.0 for n in self.law.by_output]
        )

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
        weighted = to_frequency(residual)
        weighted = weighted * floor.weights(count, self._rate) * has
        squares = np.where(has, np.mean(weighted**2, axis=0), np.nan)
        tests = len(self.runs) * len(squares)
        spread = np.std(run.stack(self.law.outputs), axis=0)
        error = _LAW_ERROR * spread / np.maximum(floor.rms, 1e-300)
        threshold = largest_mean_square(count, tests) * self._bias + error**2
        return Mismatch(squares, threshold, weighted.ravel())


def _noise_variance(runs: Sequence[Run], name: str) -> float:
    """Median over runs of the variance of a channel's noise; 0 without."""
    columns = [r.channels[name] for r in runs if name in r.channels]
    found = [noise_deviation(x) ** 2 for x in columns]
    return float(np.median(found)) if found else 0.0


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
