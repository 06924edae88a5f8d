"""Reference motions for the bench that stay within its limits.

Slow ones show dry friction, play and creep; fast ones inertia, damping and
delays; holds show what moves by itself; free runs show everything but contact
and torso. The numbers keep |y| below `limits.EXCURSION`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from brace_drake.core.errors import CampaignError, suggest
from brace_drake.devices.motions.parts import (
    growing_sine,
    multisine,
    product,
    ramp,
    steps,
)
from brace_drake.devices.motions.reference import reference_columns
from brace_drake.recording import Run
from brace_drake.recording.columns import BENCH_RINGS

RATE_HZ = 200.0
# Of multisines, Hz.
_RATES = np.array([0.15, 0.35, 0.6, 0.95, 1.45, 2.1])
_FAST = np.array([0.5, 1.1, 1.9, 2.7, 3.7, 4.9])


class PlannedMotion(Protocol):
    """A motion to run.

    Attributes:
        name: Identifier.
        meaning: What moves and how, in a few words.
        contact: As in recordings of its kind.
        run: The motion as a run that has not been recorded yet.
        columns: Channels of the run that are imposed.
    """

    @property
    def name(self) -> str: ...

    @property
    def meaning(self) -> str: ...

    @property
    def contact(self) -> bool: ...

    @property
    def run(self) -> Run: ...

    @property
    def columns(self) -> tuple[str, ...]: ...


@dataclass(frozen=True)
class MotionSet:
    """Motions for a device.

    Attributes:
        rate: Of their samples, Hz.
        motions: To choose from.
        exceeded: From (twin, motion, subject values, the twin's recording of
            it (N, C)) to which limit it passes, in words; None where it keeps
            them all.
    """

    rate: float
    motions: Sequence[PlannedMotion]
    exceeded: Callable


@dataclass(frozen=True)
class SafeMotion:
    """A reference to run; see `PlannedMotion`.

    Attributes:
        name: Identifier.
        meaning: What the ring does, in a few words.
        contact: Whether the torso is there.
        kind: push, stairs, reversal, multisine or quiet_hold.
        time: Sample times from 0 (N,), s.
        samples: y, m; y', m/s; y'', m/s^2 (N, 3); of several rings
            (N, 3, S).
        rings: Numbers of the rings that the samples are of.
    """

    name: str
    meaning: str
    contact: bool
    kind: str
    time: np.ndarray
    samples: np.ndarray
    rings: tuple[int, ...] = BENCH_RINGS

    @property
    def columns(self) -> tuple[str, ...]:
        """Channels of the reference."""
        return reference_columns(*self.rings)

    @property
    def run(self) -> Run:
        """The reference as a run that has not been recorded yet."""
        # A ring's three columns stand side by side.
        samples = self.samples.reshape(len(self.time), 3, -1)
        rows = samples.transpose(2, 1, 0).reshape(-1, len(self.time))
        columns = dict(zip(self.columns, rows, strict=True))
        channels = {"time_s": self.time, **columns}
        file = f"{self.name}.csv"
        return Run(file, self.contact, self.kind, None, "fit", channels)


def _multisine(
    t: np.ndarray, mean: float, size: float, rates: np.ndarray
) -> np.ndarray:
    """Sines of falling amplitude about a mean; at most `size` from it."""
    grow = ramp(t, 0.5, 1.5, 1.0)
    wave = multisine(t, size, rates)
    return ramp(t, 0.0, 1.5, mean) + product(grow, wave)


# y, y', y'' from the time and a motion's numbers; m, s, Hz.
_KINDS: dict[str, Callable[..., np.ndarray]] = {
    "quiet_hold": lambda t: np.zeros((len(t), 3)),
    "push": lambda t, height, rise: ramp(t, 0.5, rise, height),
    "stairs": lambda t, hold, *millimetres: steps(
        t, 1e-3 * np.array(millimetres), hold, 0.5
    ),
    "reversal": lambda t, mean, amplitude, rate: growing_sine(
        t, mean, amplitude, rate, 1.5
    ),
    "multisine": _multisine,
}

# Name: meaning, duration in s, kind with its numbers. Names of motions without
# the torso begin with "free".
_LIBRARY: dict[str, tuple[str, float, tuple]] = {
    "quiet_hold": ("still, 12 s", 12, ("quiet_hold",)),
    "quiet_hold_long": ("still, 60 s", 60, ("quiet_hold",)),
    "push": ("10 mm in 6 s, held", 12, ("push", -0.010, 6.0)),
    "push_fast": ("9 mm in 0.6 s, held", 12, ("push", -0.009, 0.6)),
    "push_deep": ("12 mm in 3 s, held", 12, ("push", -0.0119, 3.0)),
    "push_other_side": (
        "10 mm to the other side in 4 s, held",
        12,
        ("push", 0.010, 4.0),
    ),
    "push_hold_long": ("9 mm in 1 s, held", 60, ("push", -0.009, 1.0)),
    "stairs": (
        "six depths to 9 mm, 1.4 s each",
        12,
        ("stairs", 1.4, -2, -5, -9, -6, -2, -7),
    ),
    "stairs_both_sides": (
        "eight heights within 10 mm to both sides, 0.9 s each",
        12,
        ("stairs", 0.9, -3, -7, -10, -4, 4, 10, 6, 0),
    ),
    "stairs_long": (
        "three depths to 11 mm, 10 s each",
        33,
        ("stairs", 10.0, -4, -8, -11),
    ),
    "reversal": (
        "up to 4 mm about a depth of 4 mm at 0.25 Hz",
        12,
        ("reversal", -0.004, 0.004, 0.25),
    ),
    "reversal_small": (
        "up to 1 mm about a depth of 5 mm at 0.4 Hz",
        12,
        ("reversal", -0.005, 0.001, 0.4),
    ),
    "reversal_through_zero": (
        "up to 8 mm to both sides at 0.3 Hz",
        12,
        ("reversal", 0.0, 0.008, 0.3),
    ),
    "reversal_fast": (
        "up to 3 mm about a depth of 6 mm at 1.5 Hz",
        12,
        ("reversal", -0.006, 0.003, 1.5),
    ),
    "multisine": (
        "0.15 to 2.1 Hz about a depth of 5 mm",
        12,
        ("multisine", -0.005, 0.005, _RATES),
    ),
    "multisine_fast": (
        "0.5 to 4.9 Hz about a depth of 6 mm",
        12,
        ("multisine", -0.006, 0.003, _FAST),
    ),
    "free_hold": ("without torso, still", 12, ("quiet_hold",)),
    "free_reversal": (
        "without torso, up to 6 mm at 0.25 Hz",
        12,
        ("reversal", 0.0, 0.006, 0.25),
    ),
    "free_reversal_slow": (
        "without torso, up to 4 mm at 0.1 Hz",
        24,
        ("reversal", 0.0, 0.004, 0.1),
    ),
    "free_reversal_small": (
        "without torso, up to 1 mm at 0.4 Hz",
        12,
        ("reversal", 0.0, 0.001, 0.4),
    ),
    "free_reversal_fast": (
        "without torso, up to 4 mm at 1.5 Hz",
        12,
        ("reversal", 0.0, 0.004, 1.5),
    ),
    "free_multisine": (
        "without torso, 0.15 to 2.1 Hz",
        12,
        ("multisine", 0.0, 0.008, _RATES),
    ),
    "free_multisine_fast": (
        "without torso, 0.5 to 4.9 Hz",
        12,
        ("multisine", 0.0, 0.004, _FAST),
    ),
}
MOTIONS = tuple(_LIBRARY)

# What a campaign commonly holds.
STANDARD = (
    "free_multisine",
    "free_reversal",
    "quiet_hold",
    "push",
    "stairs",
    "reversal",
    "multisine",
)


def MakeMotion(name: str) -> SafeMotion:
    """The motion of the library that has a name.

    Raises:
        CampaignError: No such motion; the message offers the closest.
    """
    if name not in _LIBRARY:
        hint = suggest(name, MOTIONS)
        there = " There" if hint else "; there"
        raise CampaignError(
            f"no motion {name!r}{hint}{there} are {', '.join(MOTIONS)}"
        )
    meaning, duration, (kind, *numbers) = _LIBRARY[name]
    contact = not name.startswith("free")
    time = np.arange(round(duration * RATE_HZ)) / RATE_HZ
    samples = _KINDS[kind](time, *numbers)
    return SafeMotion(name, meaning, contact, kind, time, samples)
