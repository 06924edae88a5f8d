"""Runs of the bench diagram, logged as the recordings are."""

from __future__ import annotations

import gc
from contextlib import contextmanager

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
    context = simulator.get_mutable_context()
    # A callback finds its context's Python object faster than it makes one.
    contexts = [
        system.GetMyContextFromRoot(context)
        for system in station.diagram.GetSystems()
    ]
    with _no_garbage_collection():
        # A little further, so that the last sample is among the events.
        simulator.AdvanceTo(duration + 1e-6)
    del contexts
    log = station.sink.FindLog(context).data().T
    return np.hstack([log[:, 0:18], log[:, 19:20]])


@contextmanager
def _no_garbage_collection():
    """A run leaves no cycles behind, and looking for them takes time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
