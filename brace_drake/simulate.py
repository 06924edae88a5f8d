"""Runs of the bench diagram, logged as the recordings are."""

from __future__ import annotations

import numpy as np
from pydrake.systems.analysis import Simulator

from brace_drake.station import BenchStation


def SimulateBench(station: BenchStation, duration: float) -> np.ndarray:
    """Simulates the diagram from rest.

    Returns:
        Log (samples, 19): commands (6), N; lengths (6), m; force (3), N;
        marker (3), m; virtual position, m.
    """
    simulator = Simulator(station.diagram)
    # A little further, so that the last sample is among the events.
    simulator.AdvanceTo(duration + 1e-6)
    context = simulator.get_context()
    logs = {
        name: sink.FindLog(context).data().T
        for name, sink in station.sinks.items()
    }
    return np.hstack(
        [logs["leg_command"], logs["readings"], logs["memory"][:, [-3]]]
    )
