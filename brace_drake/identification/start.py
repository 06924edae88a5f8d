"""Where a fit begins: contact values by the paper's regression."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.bench.recorded_motion import ring_poses
from brace_drake.devices.bench.rollout import LENGTHS
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.identification.nn_contact_motion import (
    ContactMotion,
    contact_motion_from_run,
)
from brace_drake.identification.nn_regression import (
    NnContactEstimate,
    fit_contact_nn,
)
from brace_drake.recording.recording import Campaign, Run

# Slower resampling loses the damping, faster one drowns it in marker noise.
_RESAMPLE_S = 0.2


@dataclass(frozen=True)
class ContactStart:
    """Estimates of one run by both discretisations of equation (2)."""

    run: str
    consistent: NnContactEstimate
    printed: NnContactEstimate


def contact_motion(twin: BenchTwin, run: Run) -> ContactMotion:
    """What the network learns of a run: compression of the pads, and force.

    Raises:
        CampaignError: The run has no contact, or lacks a channel.
    """
    poses, _ = ring_poses(twin.numbers, twin.measured(run)[:, LENGTHS])
    return contact_motion_from_run(
        run,
        poses[:, 1],
        preload_m=twin.numbers.contact[5],
        resample_s=_RESAMPLE_S,
    )


def contact_starts(twin: BenchTwin, campaign: Campaign) -> list[ContactStart]:
    """The network's stiffness and damping from every moving fit run."""
    starts = []
    for run in campaign.split("fit"):
        if not run.contact:
            continue
        try:
            motion = contact_motion(twin, run)
            found = [
                fit_contact_nn(
                    motion.time_s,
                    motion.compression_m,
                    motion.force_N,
                    0.0,
                    discretisation=how,
                )
                for how in ("consistent", "printed")
            ]
        except BraceError:
            # A run without motion says nothing of the contact.
            continue
        starts.append(ContactStart(run.name, *found))
    return starts


def start_values(twin: BenchTwin, starts: list[ContactStart]) -> np.ndarray:
    """Nominal subject with the median k and c of the network, in limits."""
    values = np.array([p.nominal for p in twin.subject])
    if starts:
        stiffness = np.median([s.consistent.stiffness for s in starts])
        damping = np.median([s.consistent.damping for s in starts])
        for i, value in enumerate((stiffness, damping)):
            limits = twin.subject[i]
            # A start at a limit is no start.
            inside = limits.lower * 1.2, limits.upper / 1.2
            values[i] = float(np.clip(value, *inside))
    return values
