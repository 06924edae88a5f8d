"""Runs of the bench diagram, logged as the recordings are."""

from __future__ import annotations

import gc
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.core.errors import BraceError
from brace_drake.devices.bench.rollout import CHANNELS
from brace_drake.devices.motions.reference import (
    COLUMNS,
    MakeReference,
    reference_of_run,
)
from brace_drake.link.protocol.limits import Limits
from brace_drake.model.brace_station import BraceStation
from brace_drake.model.station import MakeBenchStation
from brace_drake.recording.recording import Run
from brace_drake.scenario.brace import BenchScenario

# Takes the station and the root context, when a run is over or as it goes on.
AtEnd = Callable[[BraceStation, Context], None]
# Called with the simulated time, s.
OnProgress = Callable[[float], None]
_PROGRESS_S, _WATCH_S = 0.1, 0.04


def SimulateBench(
    station: BraceStation,
    duration: float,
    at_end: AtEnd | None = None,
    on_progress: OnProgress | None = None,
    watch: AtEnd | None = None,
) -> np.ndarray:
    """Simulates the diagram from rest.

    Args:
        station: Built for a reference.
        duration: s.
        at_end: See AtEnd; for logs beside the one that is returned.
        on_progress: Called every 0.1 s of simulated time.
        watch: Called every 0.04 s; the run then is no faster than real time.

    Returns:
        Log (samples, 19): commands (6), N; lengths (6), m; force (3), N;
        marker (3), m; virtual position, m.
    """
    simulator = Simulator(station.diagram)
    context = simulator.get_context()
    AdvanceRun(simulator, station, duration, on_progress, watch)
    if at_end is not None:
        at_end(station, context)
    log = station.sink.FindLog(context).data().T
    return np.hstack([log[:, 0:18], log[:, 19:20]])


def AdvanceRun(
    simulator: Simulator,
    station: BraceStation,
    duration: float,
    on_progress: OnProgress | None = None,
    watch: AtEnd | None = None,
) -> None:
    """Advances a run from time 0 to its last sample.

    Args:
        simulator: Of the station's diagram, or of one around it.
        station: Of bench or brace.
        duration: s.
        on_progress: Called every 0.1 s of simulated time.
        watch: See `SimulateBench`.

    Raises:
        BraceError: The run broke down.
    """
    context = simulator.get_mutable_context()
    # A callback finds its context's Python object faster than it makes one.
    contexts = [
        system.GetMyContextFromRoot(context)
        for system in station.diagram.GetSystems()
    ]
    if watch is not None:
        simulator.set_target_realtime_rate(1.0)
        _monitor(simulator, station, watch)
    with without_garbage_collection(), told_as_brace_error():
        if on_progress is not None:
            for time in np.arange(_PROGRESS_S, duration, _PROGRESS_S):
                simulator.AdvanceTo(time)
                on_progress(time)
        # A little further, so that the last sample is among the events.
        simulator.AdvanceTo(duration + 1e-6)
    del contexts


def _monitor(simulator: Simulator, station: BraceStation, watch: AtEnd) -> None:
    shown = [-1]

    def Look(root: Context):
        frame = int(root.get_time() / _WATCH_S + 1e-9)
        if frame > shown[0]:
            shown[0] = frame
            watch(station, root)

    simulator.set_monitor(Look)


@contextmanager
def told_as_brace_error():
    """A simulator that gives up raises a plain RuntimeError."""
    try:
        yield
    except RuntimeError as error:
        raise BraceError(f"the simulated run broke down: {error}") from error


@contextmanager
def without_garbage_collection():
    """A run leaves no cycles behind, and looking for them takes time."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def RecordBench(
    scenario: BenchScenario,
    run: Run,
    noise_seed: int | None = None,
    at_end: AtEnd | None = None,
    on_progress: OnProgress | None = None,
    log_pads: bool = False,
    limits: Limits | None = None,
    watch: AtEnd | None = None,
) -> Run:
    """A recording that the diagram makes of a reference, from rest.

    Args:
        scenario: Of the bench, with the effects that it carries.
        run: With a reference; its `contact` says whether the torso is there.
        noise_seed: Of the instruments' noise; None: exact readings.
        at_end, on_progress, watch: See `SimulateBench`.
        log_pads, limits: See `MakeBenchStation`.

    Returns:
        The run with all channels of the bench, every `log_period`.

    Raises:
        BraceError: The simulated run broke down.
    """
    times, samples = reference_of_run(run)
    reference = MakeReference(times, samples)
    torso = replace(scenario.torso, present=run.contact)
    noise = MakeHeldNoise(noise_seed, times[-1], scenario.control.rate)
    scenario = replace(scenario, torso=torso)
    station = MakeBenchStation(
        scenario, reference, noise=noise, log_pads=log_pads, limits=limits
    )
    log = SimulateBench(station, times[-1], at_end, on_progress, watch)
    if not np.isfinite(log).all():
        raise BraceError("the simulated run broke down")
    at = np.arange(len(log)) * scenario.sensors.log_period
    desired = reference.vector_values(np.minimum(at, times[-1]))
    channels = {"time_s": at, **dict(zip(CHANNELS, log.T, strict=True))}
    channels |= dict(zip(COLUMNS, desired, strict=True))
    return replace(run, channels=channels)


def MakeHeldNoise(
    seed: int | None, duration: float, rate: float, rows: int = 12
) -> PiecewisePolynomial | None:
    """Standard normal draws (rows), each held around its control tick.

    None without a seed: exact readings.
    """
    if seed is None:
        return None
    ticks = round(duration * rate) + 3
    edges = (np.arange(ticks) - 0.5) / rate
    draws = np.random.default_rng(seed).standard_normal((ticks, rows))
    return PiecewisePolynomial.ZeroOrderHold(edges, draws.T)
