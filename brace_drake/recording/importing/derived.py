"""Desired rates that a file has not: derivatives of the desired motion."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

import numpy as np

from brace_drake.recording.columns import Channel
from brace_drake.recording.table import Columns

# A desired position and its rate; a desired rate and its own.
_POSITION = re.compile(r"(.*_)y_desired_m")
_RATE = re.compile(r"(.*_)vy_desired_m_s")


def derivable(
    channels: Mapping[str, Channel], known: Iterable[str]
) -> dict[str, str]:
    """What can be derived: by channel, of which it is the derivative.

    Args:
        channels: Of the device.
        known: Channels that there are.
    """
    found: dict[str, str] = {}
    names = set(known)
    for source, rate in _pairs(channels):
        if source in names and rate not in names:
            found[rate] = source
            names.add(rate)
    return found


def derive(columns: Columns, rates: Mapping[str, str]) -> Columns:
    """Columns with the rates that `derivable` names.

    Central differences of second order, on times that need not be even.
    """
    columns = dict(columns)
    for rate, source in rates.items():
        columns[rate] = np.gradient(columns[source], columns["time_s"])
    return columns


def _pairs(channels: Mapping[str, Channel]) -> Iterable[tuple[str, str]]:
    """Positions and rates before rates and their own."""
    for pattern, ending in (
        (_POSITION, "vy_desired_m_s"),
        (_RATE, "ay_desired_m_s2"),
    ):
        for name in channels:
            found = pattern.fullmatch(name)
            if found and found[1] + ending in channels:
                yield name, found[1] + ending
