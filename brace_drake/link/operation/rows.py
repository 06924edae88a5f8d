"""What is kept of a motion on a device: its ticks, and what the line did."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from brace_drake.link.operation.spread import Spread


@dataclass
class Row:
    """One control tick as it was recorded.

    Attributes:
        tick: Of the motion; below 0 while the ring settles.
        command: Leg commands computed at it (6 S,), N.
        readings: Lengths, forces, marker (9 S + 3,).
        desired: y_d, y_d', y_d'' (3,), of several rings (3, S).
        y_virtual: Of each ring (S,), m.
        y_ring: Displacement of each ring along y (S,), m.
        latency: From the state's arrival to the command's departure, s.
        age: Ticks between the state and that which the command in use answers.
        bridged: Whether the state was lost and its readings are interpolated.
        stiffness: K_d along y in use, of each ring (S,), N/m.
    """

    tick: int
    command: np.ndarray
    readings: np.ndarray
    desired: np.ndarray
    y_virtual: np.ndarray
    y_ring: np.ndarray
    latency: float
    age: int
    bridged: bool = False
    stiffness: np.ndarray | None = None


@dataclass
class Tally:
    """What was seen of the line during a motion.

    Attributes:
        ticks, bridged: Ticks controlled, and of them those interpolated.
        unanswered: Ticks in which the device had no new command in time.
        periods, latencies, ages: s, s, ticks.
    """

    ticks: int = 0
    bridged: int = 0
    unanswered: int = 0
    periods: Spread = field(default_factory=Spread)
    latencies: Spread = field(default_factory=Spread)
    ages: Spread = field(default_factory=Spread)
