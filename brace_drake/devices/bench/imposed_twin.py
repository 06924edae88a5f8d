"""The bench's twin with its ring carried along the recorded way.

What drives and controller do is given then: contact, torso and the reading of
their force are left to answer for. Where drives stick and slip by chance, and
no twin in closed loop follows a recording for long, this one still does.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline

from brace_drake.devices.bench.recorded_motion import low_pass, ring_poses
from brace_drake.devices.bench.rollout import (
    CHANNELS,
    FORCE,
    LENGTHS,
    Motion,
    draw_noise,
    simulate_bench,
)
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import stack_effects
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.laws.loop import guide
from brace_drake.recording.recording import Run

# The way is taken from leg lengths up to here, beyond which their noise is more
# than it; k of `laws.loop.guide`, 1/s.
_WAY_HZ, _HOLD = 15.0, 2.0 * np.pi * 20.0
# Readings are compared up to here, where 86 % of the way are left.
_READ_HZ = 12.0

_GUIDE = Effect(
    name="guide",
    block="mechanism",
    title="ring carried along a way",
    equation="M (X_r'' + 2 k (X_r' - X') + k^2 (X_r - X)) in place of the legs",
    source="Siciliano et al., Robotics, section 8.5.2 (computed torque)",
    parameters=(),
    laws={"ring": guide.follow_way},
    signature="none: what the legs do is not looked at",
    impostors={},
    experiment="none",
)


@dataclass(frozen=True)
class GuidedMotion(Motion):
    """A motion with what was recorded of its ring.

    Attributes:
        lengths: Of the legs (N, 6), m, below the noise.
        way: Of the ring with anchors at their places, see `laws.loop.guide`.
    """

    lengths: np.ndarray = field(default_factory=lambda: np.zeros((0, 6)))
    way: np.ndarray = field(default_factory=lambda: np.zeros(0))


class GuidedBenchTwin(BenchTwin):
    """Replays contact, torso and force reading on the recorded way.

    Commands, leg lengths and virtual position carry no information.

    Attributes:
        needs: Channels without which a run has no way, or nothing to compare.
    """

    needs = (*CHANNELS[LENGTHS], *CHANNELS[FORCE])
    has_loop = False
    highest_hz = _READ_HZ

    @property
    def has_room(self) -> bool:
        """Whether it takes an effect beside those carried and the guide."""
        return len(self.carried) + 2 <= MAX_EFFECTS

    def motion(self, run: Run) -> GuidedMotion:
        """The recorded trajectory of the ring, with the reference."""
        return self._guided(super().motion(run), self.measured(run))

    def active(self, run: Run) -> np.ndarray:
        """Force, and of a torso its marker, bool (C,)."""
        names = np.array(self.channels)
        force = np.char.startswith(names, "ring2_force")
        marker = np.char.startswith(names, "torso")
        return force | (marker & super().active(run))

    def _guided(self, motion: Motion, recording: np.ndarray) -> GuidedMotion:
        rate = 1.0 / (motion.ticks_per_sample * self.numbers.period)
        lengths = low_pass(recording[:, LENGTHS], _WAY_HZ, rate)
        return GuidedMotion(
            motion.desired,
            motion.with_torso,
            motion.ticks_per_sample,
            motion.settled_ticks,
            motion.columns,
            lengths,
            self._way(self.numbers, motion, lengths),
        )

    def _way(self, numbers, motion: Motion, lengths: np.ndarray) -> np.ndarray:
        """The way of the ring whose anchors are those of some numbers."""
        rate = 1.0 / (motion.ticks_per_sample * numbers.period)
        poses, _ = ring_poses(numbers, lengths)
        spline = CubicSpline(np.arange(len(poses)) / rate, poses)
        rows = np.hstack([poses, spline(spline.x, 1)])
        start = motion.settled_ticks * numbers.period
        head = [start, rate, *numbers.ring[0], _HOLD]
        return np.concatenate([head, rows.ravel()])

    def simulate_each(self, requests):
        """Side by side only where readings are exact."""
        if any(request.seed is not None for request in requests):
            return ReplayTwin.simulate_each(self, requests)
        return super().simulate_each(requests)

    def _plug_ins(self, numbers, motion, uses):
        """The effects, and what guides the ring."""
        mine, way = self.numbers, motion.way
        is_moved = not (
            np.array_equal(numbers.lower, mine.lower)
            and np.array_equal(numbers.upper, mine.upper)
        )
        if is_moved:
            way = self._way(numbers, motion, motion.lengths)
        return stack_effects([*uses, (_GUIDE, way)], numbers)

    def _replay(self, numbers, motion, subject, uses, generator):
        """On the way; noise is that of the readings and of a way so read."""
        exact = super()._replay(numbers, motion, subject, uses, None)
        if generator is None:
            return exact
        step = self.time_step
        noise = draw_noise(numbers, len(motion.desired), generator)
        free = stack_effects(uses, numbers)
        noisy = simulate_bench(numbers, motion, step, free, noise)
        # A way of noise is asked for but once, so not remembered.
        read = self._guided(motion, noisy)
        again = self._plug_ins(numbers, read, uses)
        return exact + noisy - simulate_bench(numbers, read, step, again)
