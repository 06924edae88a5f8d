"""Runs of a brace's diagram, logged as the recordings are."""

from __future__ import annotations

import gc
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.core.errors import BraceError
from brace_drake.devices.motions.reference import (
    MakeBraceReference,
    reference_columns,
)
from brace_drake.effects.stack import Use
from brace_drake.laws import stages
from brace_drake.link.protocol.limits import Limits
from brace_drake.model.brace_plant import AddGeometry
from brace_drake.model.brace_station import BraceStation, MakeControlledBrace
from brace_drake.recording.columns import BENCH, BRACE, BRACE_STAGES
from brace_drake.recording.recording import Run
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_rings

# Takes the station and the root context, when a run is over or as it goes on.
AtEnd = Callable[[BraceStation, Context], None]
# Called with the simulated time, s.
OnProgress = Callable[[float], None]
_PROGRESS_S, _WATCH_S = 0.1, 0.04


@dataclass(frozen=True)
class BraceLog:
    """A run of S stages, N samples, arrays bottom to top.

    Attributes:
        time: (N,), s, from 0.
        drive_force: Commands within the drives' limits (N, 6 S), N.
        leg_length: As read (N, 6 S), m.
        force: Of each ring on the torso, as read, in W (N, S, 3), N.
        marker: The torso's displacement as read (N, 3), m.
        X_v: Virtual pose (N, S, 6).
        X: True task coordinates (N, S, 6).
        v: True velocity of each ring's centre in W (N, S, 3), m/s.
        desired: X_d, X_d', X_d'' (N, 3, S, 6).
    """

    time: np.ndarray
    drive_force: np.ndarray
    leg_length: np.ndarray
    force: np.ndarray
    marker: np.ndarray
    X_v: np.ndarray
    X: np.ndarray
    v: np.ndarray
    desired: np.ndarray


def SimulateBrace(
    scenario: BraceScenario,
    run: Run,
    noise_seed: int | None = None,
    on_progress: OnProgress | None = None,
    add_geometry: AddGeometry | None = None,
    at_end: AtEnd | None = None,
    log_pads: bool = False,
    limits: Limits | None = None,
    watch: AtEnd | None = None,
    uses: Sequence[Use] = (),
) -> BraceLog:
    """Runs a scenario's brace, with its controller, over a reference.

    Args:
        scenario: Checked, with the effects that it carries.
        run: With a reference; its `contact` says whether the torso is there.
        noise_seed: Of the instruments' noise; None: exact readings.
        on_progress, at_end, watch: See `SimulateStation`.
        add_geometry: See `AddBracePlant`, as `torso.contact` makes it.
        log_pads, limits, uses: See `MakeBraceStation`.

    Raises:
        BraceError: The reference is of other rings, the run broke down, or a
            leg left its stroke.
    """
    torso = replace(scenario.torso, present=run.contact)
    scenario = replace(scenario, torso=torso)
    rings, n = pack_rings(scenario), len(scenario.stages)
    desired = MakeBraceReference(run, scenario.stages, rings.start)
    end, rate = desired.end_time(), scenario.control.rate
    station = MakeControlledBrace(
        scenario,
        desired,
        noise=MakeHeldNoise(noise_seed, end, rate, 9 * n + 3),
        add_geometry=add_geometry if run.contact else None,
        log_pads=log_pads,
        limits=limits,
        uses=uses,
    )
    logged, state = SimulateStation(station, end, at_end, on_progress, watch)
    if not (np.isfinite(logged).all() and np.isfinite(state).all()):
        raise BraceError("the simulated run broke down")
    # What is logged in multiples of a period is of no other length.
    time = np.arange(len(logged)) * scenario.sensors.log_period
    poses, v = _ring_states(station.plant, scenario, state)
    sizes = np.cumsum([6 * n, 6 * n, 3 * n, 3])
    force, lengths, contact, marker, virtual = np.split(logged, sizes, axis=1)
    wanted = desired.vector_values(np.minimum(time, end)).T
    log = BraceLog(
        time=time,
        drive_force=force,
        leg_length=lengths,
        force=contact.reshape((-1, n, 3)),
        marker=marker,
        X_v=virtual.reshape((-1, 3, n, 6))[:, 0],
        X=_task_coordinates(poses, rings.geometry.rest),
        v=v,
        desired=wanted.reshape((-1, 3, n, 6)),
    )
    _check_stroke(scenario, log, rings.geometry.rest_lengths)
    return log


def RecordBrace(scenario: BraceScenario, run: Run, **options) -> Run:
    """A recording of a reference: `SimulateBrace` as channels.

    Legs and rings have the numbers of the whole brace; stage 2 alone records
    as the bench does, legs 1 to 6.

    Args:
        scenario, run: See `SimulateBrace`.
        options: Its other arguments.
    """
    log = SimulateBrace(scenario, run, **options)
    lowest = 1 if recorded_device(scenario) == BENCH else scenario.stages[0]
    channels = {"time_s": log.time}
    for k in range(log.leg_length.shape[1]):
        leg = f"leg{6 * (lowest - 1) + k + 1}"
        channels[f"{leg}_force_command_N"] = log.drive_force[:, k]
        channels[f"{leg}_length_m"] = log.leg_length[:, k]
    for i, ring in enumerate(scenario.stages):
        for c, axis in enumerate("xyz"):
            channels[f"ring{ring}_force_{axis}_N"] = log.force[:, i, c]
        reference = log.desired[:, :, i, 1].T
        channels |= dict(zip(reference_columns(ring), reference, strict=True))
        channels[f"ring{ring}_y_virtual_m"] = log.X_v[:, i, 1]
    for c, axis in enumerate("xyz"):
        channels[f"torso_{axis}_m"] = log.marker[:, c]
    return replace(run, channels=channels)


def recorded_device(scenario: BraceScenario) -> str:
    """What a recording of the scenario's stages is of."""
    return BENCH if scenario.stages == [2] else BRACE


def recorded_stages(scenario: BraceScenario) -> tuple[int, ...]:
    """Stages that its campaign has to name; none where all are there."""
    stages = tuple(scenario.stages)
    return () if stages in (BRACE_STAGES, (2,)) else stages


def SimulateStation(
    station: BraceStation,
    duration: float,
    at_end: AtEnd | None = None,
    on_progress: OnProgress | None = None,
    watch: AtEnd | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Simulates a diagram from rest.

    Args:
        station: With nothing left to be fed.
        duration: s.
        at_end: Called with station and root context after the run.
        on_progress: Called every 0.1 s of simulated time.
        watch: Called every 0.04 s; the run then is no faster than real time.

    Returns:
        What `sink` and `state_sink` have logged (N, ...), see `BraceStation`.

    Raises:
        BraceError: The run broke down.
    """
    simulator = Simulator(station.diagram)
    context = simulator.get_context()
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
    if on_progress is not None:
        on_progress(duration)
    if at_end is not None:
        at_end(station, context)
    logs = station.sink, station.state_sink
    return tuple(sink.FindLog(context).data().T for sink in logs)


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


def MakeHeldNoise(
    seed: int | None, duration: float, rate: float, rows: int
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


def _ring_states(
    plant: MultibodyPlant, scenario: BraceScenario, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Poses (N, S, 7), q then p, and velocities (N, S, 3) of the rings."""
    poses, v = [], []
    for name in scenario.rings:
        body = plant.GetBodyByName(name)
        q = body.floating_positions_start()
        # Drake's spatial velocities have the rotation first.
        at = plant.num_positions() + body.floating_velocities_start_in_v() + 3
        poses.append(states[:, q : q + 7])
        v.append(states[:, at : at + 3])
    return np.stack(poses, axis=1), np.stack(v, axis=1)


def _task_coordinates(poses: np.ndarray, rest: np.ndarray) -> np.ndarray:
    X = np.empty((len(poses), 6 * len(rest)))
    for k, sample in enumerate(np.ascontiguousarray(poses)):
        stages.calc_task_coordinates(sample, rest, X[k])
    return X.reshape((-1, len(rest), 6))


def _check_stroke(
    scenario: BraceScenario, log: BraceLog, rest: np.ndarray
) -> None:
    """Refuses what legs without stops do in the twin, and no real leg can."""
    off = np.abs(log.leg_length - np.ravel(rest))
    outside = off > scenario.leg.stroke / 2.0
    if not outside.any():
        return
    sample, leg = np.argwhere(outside)[0]
    leg += 6 * (scenario.stages[0] - 1) + 1
    raise BraceError(
        f"leg {leg} is {1e3 * off[outside][0]:.1f} mm from its length at rest"
        f" at {log.time[sample]:.3f} s; its stroke allows"
        f" {500.0 * scenario.leg.stroke:g} mm"
    )
