"""Phases of a motion: what the machine is doing at each sample."""

from __future__ import annotations

import numpy as np

from brace_drake.devices.declaration import MotionSignals

PHASES = (
    "reversal",
    "hold",
    "loading",
    "unloading",
    "free motion",
    "contact made or lost",
    "breath rising",
    "breath falling",
)
# Slower than this share of a run's top speed is rest.
_SLOW = 0.1
# Samples on both sides of a change of direction, or of contact, that belong
# to it.
_AROUND_S = 0.15
# A breath is smoothed over so long before its direction is taken.
_BREATH_S = 0.5


def motion_phases(
    signals: MotionSignals,
    measured: np.ndarray,
    rate: float,
    contact: bool,
    breath: np.ndarray | None = None,
) -> np.ndarray:
    """Phase of each sample, an index into PHASES (N,).

    Args:
        signals: Of the run.
        measured: Recorded channels (N, C).
        rate: Hz.
        contact: Whether the torso is there.
        breath: What a breath adds to the force (N,), N; while the brace holds
            still, its rise and fall are the phases.
    """
    velocity = np.gradient(signals.position) * rate
    top = np.max(np.abs(velocity))
    moving = np.abs(velocity) > _SLOW * top
    phase = np.where(moving, PHASES.index("free motion"), PHASES.index("hold"))
    if contact and breath is not None:
        rising = np.gradient(_smooth(breath, round(_BREATH_S * rate))) > 0.0
        phase[~moving & rising] = PHASES.index("breath rising")
        phase[~moving & ~rising] = PHASES.index("breath falling")
    if contact and signals.force is not None:
        loading = velocity * np.sign(measured[:, signals.force]) > 0.0
        phase[moving & loading] = PHASES.index("loading")
        phase[moving & ~loading] = PHASES.index("unloading")
    if top > 0.0:
        # A real motion turns into its opposite in the middle of a standstill,
        # or at its end where that is long.
        fast = np.flatnonzero(moving)
        signs = np.sign(velocity[fast])
        turns = np.flatnonzero(signs[1:] != signs[:-1])
        before, after = fast[turns], fast[turns + 1]
        is_long = after - before > round(2 * _AROUND_S * rate)
        at = np.where(is_long, after, (before + after) // 2)
        _mark(phase, at, "reversal", rate)
    if contact and signals.touching is not None:
        changes = np.any(np.diff(signals.touching, axis=0), axis=1)
        at = np.flatnonzero(changes)
        _mark(phase, at, "contact made or lost", rate)
    return phase


def _mark(phase: np.ndarray, samples, name: str, rate: float) -> None:
    width = max(1, round(_AROUND_S * rate))
    for at in samples:
        phase[max(0, at - width) : at + width] = PHASES.index(name)


def _smooth(signal: np.ndarray, width: int) -> np.ndarray:
    """Mean over a window, the ends held."""
    width = max(1, width)
    padded = np.pad(signal, (width // 2, width - 1 - width // 2), mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")
