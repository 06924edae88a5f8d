"""Which channels of a run are sensors, which are given, and which may rest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from brace_drake.recording.columns import Channel
from brace_drake.recording.recording import Campaign, Run

_GIVEN = ("time_s",)


def declared(campaign: Campaign) -> dict[str, Channel]:
    """Declarations of a campaign's channels, by name."""
    return campaign.known_channels


def is_desired(name: str) -> bool:
    """Whether a channel is the motion that is asked for."""
    return "desired" in name


def is_computed(name: str) -> bool:
    """Whether a channel is what the controller computes, no sensor's."""
    return "command" in name or "virtual" in name


def desired_channels(run: Run) -> list[str]:
    """Channels of the motion that is asked for."""
    return [n for n in run.channels if is_desired(n)]


def is_given(channel: Channel) -> bool:
    """Whether a channel is put in, or computed from what is put in alone."""
    return (
        channel.name in _GIVEN
        or channel.is_input
        or is_desired(channel.name)
        or channel.name in ("displacement_m",)
    )


def noisy_channels(run: Run, known: Mapping[str, Channel]) -> list[str]:
    """Channels in which each sample has noise of its own: readings, and the
    commands computed from them; not those of a torso that is not there.
    """
    return [
        name
        for name, channel in known.items()
        if name in run.channels
        and not is_given(channel)
        and channel.constant != "still"
        and (run.contact or channel.constant != "free")
    ]


def references(run: Run, known: Mapping[str, Channel]) -> list[str]:
    """Channels that are put in, but for the time."""
    return [
        n
        for n, c in known.items()
        if n in run.channels and (c.is_input or c.is_way)
    ]


def moves(run: Run, known: Mapping[str, Channel]) -> bool:
    """Whether anything in a run is asked to move."""
    return any(
        float(np.ptp(run.channels[n])) > 0.0 for n in references(run, known)
    )
