"""The pad bench's twin as fits and diagnoses see it."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.pad_bench.motion import MakePadMotion, PadMotion
from brace_drake.devices.subject import SubjectParameter
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.stack import stack_effects
from brace_drake.laws.alone.pad_rollout import rollout_pad
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.recording.columns import PAD_BENCH
from brace_drake.recording.recording import Run
from brace_drake.scenario.pad_bench import (
    PadBenchNumbers,
    PadBenchScenario,
    pack_pad_bench,
)
from brace_drake.scenario.pad_noise import NOISE_EDGES_HZ

CHANNELS = ("force_N",)
# Plug points that a pad has.
POINTS = ("compression", "contact", "sensing")

# Specimens may be that many times softer or stiffer than nominal: from fat to
# muscle, and from the first touch to the full depth, tissue spans decades.
_SPREAD = 30.0
# A fit counts damping in what makes this share of the elastic force, or in its
# start value where that is more.
_DAMPING_SHARE = 0.1
# Limits in that unit; the lower one is as good as none, and keeps the damping's
# companions in the equations.
_LEAST_DAMPING, _MOST_DAMPING = 1e-4, 10.0
# Longer steps that suffice for differences between points.
_COARSE = 4.0

# Places that the rollout needs beside the readings.
_WORK = 20


def simulate_pad(
    numbers: PadBenchNumbers,
    time: np.ndarray,
    path: np.ndarray,
    time_step: float,
    plug_ins: Mapping[str, PlugIn] | None = None,
) -> np.ndarray:
    """Simulates one run with the compiled rollout.

    Args:
        numbers: The twin.
        time: Sample times from 0 (N,), s.
        path: Displacement, m, and rate, m/s, at the samples (N, 2).
        time_step: Longest step of the effects' states, s.
        plug_ins: Effects by plug point.

    Returns:
        Force readings (N,), N.

    Raises:
        BraceError: The run broke down (the message says when).
    """
    given = plug_ins or {}
    plugs = [given.get(point) or idle(point) for point in POINTS]
    work = np.zeros(len(time) + _WORK)
    broke_at = rollout_pad(
        steps_per_sample(time, time_step),
        time,
        path,
        numbers.contact,
        *(p.laws for p in plugs),
        plugs[0].parameters,
        *(p.fresh_memory() for p in plugs),
        np.array([p.active for p in plugs]),
        work,
    )
    if broke_at >= 0:
        raise BraceError(
            f"the simulated run broke down at {time[broke_at]:.3f} s"
        )
    return work[: len(time)].copy()


def steps_per_sample(time: np.ndarray, time_step: float) -> int:
    """Steps between two samples, none of them longer than `time_step`."""
    return math.ceil(float(np.median(np.diff(time))) / time_step - 1e-9)


class PadBenchTwin(ReplayTwin):
    """Presses a pad along recorded displacements."""

    channels = CHANNELS
    device = PAD_BENCH
    has_loop = False

    def __init__(
        self, scenario: PadBenchScenario, time_step: float | None = None
    ):
        super().__init__(scenario, pack_pad_bench(scenario), time_step)
        self.subject = pad_subject(self.numbers, scenario.corner_share)

    def coarse(self) -> PadBenchTwin:
        """The same twin with longer steps of the effects' states."""
        return PadBenchTwin(self.scenario, self.time_step * _COARSE)

    def scenario_of(self, subject: np.ndarray) -> PadBenchScenario:
        """The scenario with a specimen's numbers, a copy."""
        out = copy.deepcopy(self.scenario)
        out.stiffness, out.damping, out.contact_offset = map(float, subject[:3])
        out.corner_share = self.corner_share(subject)
        return out

    def motion(self, run: Run) -> PadMotion:
        """The run's path."""
        return MakePadMotion(
            run.time_s,
            run.channels["displacement_m"],
            self.numbers.displacement_noise[0],
        )

    def _replay(self, numbers, motion, subject, uses, generator):
        """The noise of displacement goes through the motion's smoothing."""
        noise, force_noise = None, 0.0
        if generator is not None:
            noise = generator.standard_normal(len(motion.time))
            noise = noise * numbers.displacement_noise[0]
            force_noise = draw_force_noise(
                numbers.force_noise, motion.time, generator
            )
        force = simulate_pad(
            numbers,
            motion.time,
            motion.path(noise, self.corner_share(subject)),
            self.time_step,
            stack_effects(uses),
        )
        return (force + force_noise)[:, None]

    def with_subject(self, values: np.ndarray) -> PadBenchNumbers:
        """The numbers of a specimen, values in the order of `subject`."""
        contact = self.numbers.contact.copy()
        contact[0], contact[1], contact[5] = values[0], values[1], -values[2]
        return self.numbers.with_changes(contact=contact)

    def corner_share(self, values: np.ndarray) -> float:
        """What a specimen's `corner_share` is, 0 where nothing tells it."""
        return float(values[3]) if len(self.subject) > 3 else 0.0


def pad_subject(
    numbers: PadBenchNumbers, corner_share: float = 0.0
) -> tuple[SubjectParameter, ...]:
    """Subject parameters of the pad bench with nominal values and limits.

    The contact offset is the displacement at which the pad touches; below all
    recorded ones where it never leaves. The corner share is the instruments':
    at a corner of the path the rate is known only to lie between the slopes on
    both sides, so that what the damping makes of it is fitted.
    """
    k, c, offset = numbers.contact[0], numbers.contact[1], -numbers.contact[5]
    depth, rate = numbers.scales
    unit = max(c, _DAMPING_SHARE * k * depth / rate)
    parameters = (
        SubjectParameter("stiffness_N_m", "N/m", k, k / _SPREAD, k * _SPREAD),
        SubjectParameter(
            "damping_N_s_m",
            "N s/m",
            max(c, _LEAST_DAMPING * unit),
            _LEAST_DAMPING * unit,
            _MOST_DAMPING * unit,
            unit,
        ),
        SubjectParameter(
            "contact_offset_m",
            "m",
            offset,
            offset - 2.0 * depth,
            offset + depth,
            depth,
        ),
    )
    if not numbers.has_corners:
        return parameters
    share = SubjectParameter("corner_share", "1", corner_share, -0.5, 0.5, 1.0)
    return (*parameters, share)


def draw_force_noise(
    sigma: np.ndarray, time: np.ndarray, generator: np.random.Generator
) -> np.ndarray:
    """One draw of the noise of force readings (N,), N.

    Args:
        sigma: In the bands of NOISE_EDGES_HZ (B,), N.
        time: Sample times (N,), s.
        generator: Source of the draw.
    """
    white = generator.standard_normal(len(time))
    if np.all(sigma == sigma[0]):
        return sigma[0] * white
    step = float(np.median(np.diff(time)))
    frequency = np.fft.rfftfreq(len(time), step)
    band = np.searchsorted(NOISE_EDGES_HZ, frequency, side="right") - 1
    return np.fft.irfft(sigma[band] * np.fft.rfft(white), len(time))
