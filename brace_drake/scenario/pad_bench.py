"""The pad bench's scenario: one pad pressed into tissue along a given path."""

from dataclasses import dataclass, replace

import numpy as np

from brace_drake.laws.alone.pad_path import (
    filter_cosines,
    noise_gain,
    path_slopes,
)
from brace_drake.recording.columns import PAD_BENCH
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.brace import EffectUse
from brace_drake.scenario.fields import items, number, vector
from brace_drake.scenario.pad_noise import (
    NOISE_EDGES_HZ,
    estimate_displacement_noise,
    estimate_force_noise,
)
from brace_drake.scenario.pad_start import estimate_contact


@dataclass(slots=True)
class PadBenchScenario:
    """One pad: N = max(0, k d + c d') where d = displacement - offset > 0."""

    device: str = PAD_BENCH
    # Longest step of the effects' states.
    time_step: float = number(0.0005, "s", above=0.0)
    stiffness: float = number(6400.0, "N/m", above=0.0)
    damping: float = number(150.0, "N s/m", least=0.0)
    # Displacement at which the pad touches.
    contact_offset: float = number(0.0, "m")
    # Standard deviation that a reading would have were its noise at all
    # frequencies as strong as from this one of NOISE_EDGES_HZ on.
    force_noise: np.ndarray = vector(
        *[0.0] * len(NOISE_EDGES_HZ), unit="N", least=0.0
    )
    # Standard deviation of a reading.
    displacement_noise: float = number(0.0, "m", least=0.0)
    # Excursion of the pad and its rate that the fit's steps go by.
    depth_scale: float = number(0.01, "m", above=0.0)
    rate_scale: float = number(0.01, "m/s", above=0.0)
    has_corners: bool = False  # whether the path has corners on samples
    # Of the jump of the rate at such a corner, what counts beyond its mean.
    corner_share: float = number(0.0)
    effects: list[EffectUse] = items()


@dataclass(frozen=True)
class PadBenchNumbers:
    """The scenario's numbers as the laws take them.

    Attributes:
        contact: Stiffness, damping, friction, regularisation speed, pad
            offset, preload (6,), as the bench has it; here the preload is
            minus the contact offset, and the three before it do not count.
        force_noise: In the bands of NOISE_EDGES_HZ (B,), N.
        displacement_noise: (1,), m.
        scales: Of depth, m, and rate, m/s (2,).
        has_corners: Whether the path has corners on samples.
    """

    contact: np.ndarray
    force_noise: np.ndarray
    displacement_noise: np.ndarray
    scales: np.ndarray
    has_corners: bool

    def with_changes(self, **arrays: np.ndarray) -> "PadBenchNumbers":
        """A copy with some arrays replaced."""
        return replace(self, **arrays)


def pack_pad_bench(scenario: PadBenchScenario) -> PadBenchNumbers:
    """Arrays of the nominal twin that a scenario describes."""
    return PadBenchNumbers(
        contact=np.array(
            [
                scenario.stiffness,
                scenario.damping,
                0.0,
                1.0,
                0.0,
                -scenario.contact_offset,
            ]
        ),
        force_noise=np.array(scenario.force_noise, dtype=float),
        displacement_noise=np.array([scenario.displacement_noise]),
        scales=np.array([scenario.depth_scale, scenario.rate_scale]),
        has_corners=scenario.has_corners,
    )


def MakePadBenchScenario(campaign: Campaign) -> PadBenchScenario:
    """The nominal pad bench of a campaign.

    Stiffness and damping are the campaign's `nominal` and, where it has none,
    those of the recordings to be fitted; contact offset and noise always are.
    """
    runs = campaign.split("fit")
    found = estimate_contact(
        runs,
        campaign.nominal.get("stiffness_N_m"),
        campaign.nominal.get("damping_N_s_m"),
    )
    sigma = estimate_displacement_noise(runs)
    return PadBenchScenario(
        stiffness=found.stiffness,
        damping=found.damping,
        contact_offset=found.offset,
        force_noise=estimate_force_noise(runs, campaign.rate_hz),
        displacement_noise=sigma,
        depth_scale=found.depth_scale,
        rate_scale=found.rate_scale,
        has_corners=any(_has_corners(run, sigma) for run in runs),
    )


def _has_corners(run: Run, sigma: float) -> bool:
    displacement = run.channels["displacement_m"]
    smooth = filter_cosines(displacement, noise_gain(displacement, sigma))
    return bool(np.any(path_slopes(run.time_s, smooth, sigma)[1]))
