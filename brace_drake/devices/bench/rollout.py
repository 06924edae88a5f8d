"""Compiled runs of the bench: numbers and effects in, a log out."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.laws.control.brace_control import PIC, start_held
from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.rollout import RunPlan, rollout_brace
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import PlugIn, make_effects

CHANNELS = (
    *(f"leg{k}_force_command_N" for k in range(1, 7)),
    *(f"leg{k}_length_m" for k in range(1, 7)),
    *(f"ring2_force_{a}_N" for a in "xyz"),
    *(f"torso_{a}_m" for a in "xyz"),
    "ring2_y_virtual_m",
)
# Places of channels in a log.
COMMANDS, LENGTHS = slice(0, 6), slice(6, 12)
FORCE, MARKER = slice(12, 15), slice(15, 18)
VIRTUAL = 18


@dataclass(frozen=True)
class Motion:
    """What a run is asked to do: reference at ticks, torso there or not.

    Attributes:
        desired: X_d, X_d', X_d'' (ticks, 3) of the coordinate that moves, or
            (ticks, 3, m) of several.
        with_torso: Whether it is there.
        ticks_per_sample: Of the log.
        settled_ticks: Ticks at the beginning that the log leaves out.
        columns: Which task coordinates move (m,): the bench's ring along y.
    """

    desired: np.ndarray
    with_torso: bool
    ticks_per_sample: int = 5
    settled_ticks: int = 0
    columns: tuple[int, ...] = (1,)

    @cached_property
    def digest(self) -> bytes:
        """Of the reference."""
        return hashlib.sha256(self.desired.tobytes()).digest()

    @property
    def ways(self) -> np.ndarray:
        """The reference of each coordinate that moves (ticks, 3, m)."""
        return self.desired.reshape((len(self.desired), 3, -1))

    @property
    def rows(self) -> slice:
        """Those of a log that are handed on: not while it settles."""
        every = self.ticks_per_sample
        last = (len(self.desired) - 1) // every
        return slice(self.settled_ticks // every, last + 1)

    def plan(self, noise: np.ndarray, log: np.ndarray) -> RunPlan:
        """What the compiled rollout takes; noise and log as there."""
        columns = np.array(self.columns, dtype=np.int64)
        return RunPlan(
            np.ascontiguousarray(self.ways),
            columns,
            noise,
            self.ticks_per_sample,
            log,
        )


# Noise, in steps of a reading, by which its rounding is smoothed: the mean
# error of a rounded reading is then below a hundredth of a step.
_SMOOTHED = 0.45


def draw_noise(
    numbers: BraceNumbers, ticks: int, generator: np.random.Generator
) -> np.ndarray:
    """Reading noise of a run (ticks, 9n + 3): lengths, forces, marker."""
    sigma = numbers.noise_sigma
    return generator.standard_normal((ticks, len(sigma))) * sigma


def smooth_rounding(numbers: BraceNumbers) -> BraceNumbers:
    """Numbers of a noisy replay that is to be averaged.

    Rounding to steps q becomes noise of its variance, q^2 / 12: as good where
    the noise of readings is about half a step or more (Widrow and Kollar,
    Quantization Noise, 2008), and then a small change of a number changes the
    replay little. Rounded readings flip, and the loop carries that on as if
    other noise had been drawn. Where noise is less, readings stay rounded.
    """
    sigma, lengths = numbers.noise_sigma, 6 * numbers.num_stages
    forces = lengths + 3 * numbers.num_stages
    least = np.array([sigma[:lengths].min(), sigma[lengths:forces].min()])
    stays = least < _SMOOTHED * numbers.resolution
    resolution = np.where(stays, numbers.resolution, 0.0)
    smoothed = numbers.reading_steps
    smoothed -= numbers.with_changes(resolution=resolution).reading_steps
    return numbers.with_changes(
        resolution=resolution,
        noise_sigma=np.hypot(sigma, smoothed / np.sqrt(12.0)),
    )


def simulate_bench(
    numbers: BraceNumbers,
    motion: Motion,
    time_step: float,
    plug_ins: Mapping[str, PlugIn] | None = None,
    noise: np.ndarray | None = None,
) -> np.ndarray:
    """Simulates one run from rest with the compiled rollout, under PIC.

    Args:
        numbers: The twin, of n >= 1 moving rings.
        motion: The run.
        time_step: Plant step, s; the control period is a multiple of it.
        plug_ins: Effects by plug point; none where absent.
        noise: From `draw_noise`; None gives exact readings, not rounded.

    Returns:
        Log (samples, 15n + 3 + m); of the bench its columns are CHANNELS.

    Raises:
        BraceError: The run broke down (the message says when).
    """
    n, size = numbers.num_stages, len(numbers.noise_sigma)
    steps = round(numbers.period / time_step)
    log = np.zeros((motion.rows.stop, 6 * n + size + len(motion.columns)))
    held = start_held(numbers.start, numbers.rest, np.zeros((1, 6 * n)))
    broke_at = rollout_brace(
        numbers.period / steps,
        steps,
        numbers,
        make_effects(plug_ins or {}, n),
        make_brace(numbers, motion.with_torso),
        (PIC, held),
        motion.plan(np.zeros((0, size)) if noise is None else noise, log),
    )
    if broke_at >= 0:
        raise BraceError(
            f"the simulated run broke down at {broke_at * numbers.period:.3f} s"
        )
    return log[motion.rows]
