"""Compiled runs of the bench: numbers and effects in, a log out."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.laws.hooks import PLUG_POINTS
from brace_drake.laws.loop.bench_rollout import NUM_LOGGED, rollout_bench
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.scenario.bench_numbers import BenchNumbers

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
        desired: y_d, y_d', y_d'' (ticks, 3).
        with_torso: Whether it is there.
        ticks_per_sample: Of the log.
        settled_ticks: Ticks at the beginning that the log leaves out.
    """

    desired: np.ndarray
    with_torso: bool
    ticks_per_sample: int = 5
    settled_ticks: int = 0

    @cached_property
    def digest(self) -> bytes:
        """Of the reference."""
        return hashlib.sha256(self.desired.tobytes()).digest()


def rest_state(rest: np.ndarray) -> np.ndarray:
    """Ring and torso at rest: q_WR, p_WR, q_WT, p_WT, V_WR, V_WT (26,)."""
    bodies = np.zeros(26)
    bodies[0] = bodies[7] = 1.0
    bodies[4:7] = bodies[11:14] = rest
    return bodies


def draw_noise(
    numbers: BenchNumbers, ticks: int, generator: np.random.Generator
) -> np.ndarray:
    """Reading noise of a run (ticks, 12): lengths, force, marker."""
    return generator.standard_normal((ticks, 12)) * numbers.noise_sigma


def simulate_bench(
    numbers: BenchNumbers,
    motion: Motion,
    time_step: float,
    plug_ins: Mapping[str, PlugIn] | None = None,
    noise: np.ndarray | None = None,
) -> np.ndarray:
    """Simulates one run from rest with the compiled rollout.

    Args:
        numbers: The twin.
        motion: The run.
        time_step: Plant step, s; the control period is a multiple of it.
        plug_ins: Effects by plug point; none where absent.
        noise: From `draw_noise`; None gives exact readings, not rounded.

    Returns:
        Log (samples, 19), columns CHANNELS.

    Raises:
        BraceError: The run broke down (the message says when).
    """
    period = numbers.period
    steps_per_tick = round(period / time_step)
    plugs = {p: (plug_ins or {}).get(p) or idle(p) for p in PLUG_POINTS}
    ticks = len(motion.desired)
    samples = (ticks - 1) // motion.ticks_per_sample + 1
    log = np.zeros((samples, NUM_LOGGED))
    broke_at = rollout_bench(
        period / steps_per_tick,
        steps_per_tick,
        motion.ticks_per_sample,
        motion.with_torso,
        motion.desired,
        (numbers.p_WB, numbers.p_RT),
        (
            numbers.rest,
            numbers.viscous,
            numbers.contact,
            numbers.posture,
            numbers.controller_law,
            numbers.resolution,
        ),
        (numbers.ring, numbers.torso),
        np.zeros((0, 12)) if noise is None else noise,
        rest_state(numbers.rest),
        *(plugs[p].laws for p in PLUG_POINTS),
        _parameters(plugs),
        *(plugs[p].fresh_memory() for p in PLUG_POINTS),
        np.array([plugs[p].active for p in PLUG_POINTS]),
        log,
    )
    if broke_at >= 0:
        raise BraceError(
            f"the simulated run broke down at {broke_at * period:.3f} s"
        )
    return log[motion.settled_ticks // motion.ticks_per_sample :]


def _parameters(plugs: Mapping[str, PlugIn]) -> tuple[np.ndarray, ...]:
    for plug in plugs.values():
        if not plug.is_idle:
            return plug.parameters
    return plugs[PLUG_POINTS[0]].parameters
