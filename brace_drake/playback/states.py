"""What a playback shows: poses and forces over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context

from brace_drake.kinematics import BraceGeometry, find_task_coordinates
from brace_drake.laws import stages
from brace_drake.model.brace_station import BraceStation

LEFT, RIGHT = 0, 1  # pads at +y and -y of a ring


@dataclass(frozen=True)
class PlaybackStates:
    """Poses in W at N times, of rings bottom to top.

    Attributes:
        times: From 0, rising (N,), s.
        rings: q_WR (w, x, y, z), p_WR, m, of each ring (N, S, 7).
        torso: The same of the torso (N, 7); None: there is none.
        pad_force: Force of each pad on the torso in W (N, S, 2, 3), N, left
            pad, at +y, first.
        is_of_pads: Whether that is of each pad, or the net force of a ring at
            the pad that presses.
    """

    times: np.ndarray
    rings: np.ndarray
    torso: np.ndarray | None
    pad_force: np.ndarray
    is_of_pads: bool = False

    def frames(self, frames_per_second: float) -> np.ndarray:
        """Index of the sample nearest to each frame, the first at time 0."""
        last = self.times[-1] - self.times[0]
        at = np.arange(int(last * frames_per_second + 1e-9) + 1)
        at = self.times[0] + at / frames_per_second
        after = np.searchsorted(self.times, at).clip(1, len(self.times) - 1)
        if len(self.times) == 1:
            return np.zeros(1, dtype=int)
        nearer = at - self.times[after - 1] < self.times[after] - at
        return after - nearer


def place_on_pads(force: np.ndarray) -> np.ndarray:
    """Net force of each ring on the torso, shown at the pad that presses.

    Instruments measure the sum of a ring's two pads. Pads only press, so a
    sum along -y comes from the left pad, at +y, or more from it.

    Args:
        force: (N, 3 S), N, in W.

    Returns:
        (N, S, 2, 3), N; 0 at the other pad.
    """
    force = np.reshape(force, (len(force), -1, 3))
    placed = np.zeros((*force.shape[:2], 2, 3))
    left = force[..., 1:2] < 0.0
    placed[..., LEFT, :] = np.where(left, force, 0.0)
    placed[..., RIGHT, :] = np.where(left, 0.0, force)
    return placed


def states_of_run(
    station: BraceStation,
    context: Context,
    rings: Sequence[str],
    force: np.ndarray,
) -> PlaybackStates:
    """Poses and forces of a simulated run, from the station's logs.

    Where the station has logged the forces of single pads, they are shown; else
    `force` is placed on pads.

    Args:
        station: Of bench or brace.
        context: Of its diagram, when the run is over.
        rings: Names of its moving rings, bottom to top.
        force: Net force of each ring on the torso at the samples of the
            station's log (N, 3 S), N.
    """
    log, plant = station.state_sink.FindLog(context), station.plant
    own, poses = plant.CreateDefaultContext(), []
    for now in log.data().T:
        plant.SetPositionsAndVelocities(own, now)
        poses.append(_read_poses(plant, own, rings))
    poses, n, times = np.array(poses), len(rings), log.sample_times().copy()
    torso = poses[:, n] if poses.shape[1] > n else None
    if station.pad_sink is not None:
        pads = station.pad_sink.FindLog(context).data().T
        pad_force, is_of_pads = pads.reshape(-1, n, 2, 3), True
    else:
        pad_force, is_of_pads = place_on_pads(force), False
    return PlaybackStates(times, poses[:, :n], torso, pad_force, is_of_pads)


def states_of_now(
    station: BraceStation, context: Context, rings: Sequence[str]
) -> PlaybackStates:
    """The same of a run that goes on, at one time.

    Args:
        station: Of bench or brace.
        context: The root one.
        rings: Names of its moving rings, bottom to top.
    """
    plant, n = station.plant, len(rings)
    own = plant.GetMyContextFromRoot(context)
    poses = _read_poses(plant, own, rings)[None]
    torso = poses[:, n] if poses.shape[1] > n else None
    times = np.array([context.get_time()])
    if station.pad_sink is not None:
        pads = station.diagram.GetSubsystemByName("pad_forces")
        force = pads.get_output_port().Eval(pads.GetMyContextFromRoot(context))
        pad_force, is_of_pads = force.reshape((1, n, 2, 3)), True
    else:
        diagram = station.diagram.GetMyContextFromRoot(context)
        force = station.diagram.GetOutputPort("force").Eval(diagram)
        pad_force, is_of_pads = place_on_pads(force[None]), False
    return PlaybackStates(times, poses[:, :n], torso, pad_force, is_of_pads)


def _read_poses(
    plant: MultibodyPlant, own: Context, rings: Sequence[str]
) -> np.ndarray:
    """q, p in W of the rings and, where there is one, the torso (n, 7)."""
    names = [*rings, "torso"] if plant.HasBodyNamed("torso") else list(rings)
    poses = np.empty((len(names), 7))
    for pose, name in zip(poses, names, strict=True):
        X_WB = plant.EvalBodyPoseInWorld(own, plant.GetBodyByName(name))
        pose[0:4] = X_WB.rotation().ToQuaternion().wxyz()
        pose[4:7] = X_WB.translation()
    return poses


def states_of_readings(
    geometry: BraceGeometry,
    times: np.ndarray,
    lengths: np.ndarray,
    force: np.ndarray,
    torso: np.ndarray | None,
) -> PlaybackStates:
    """Poses from what a recording has, by forward kinematics.

    Args:
        geometry: Of the brace.
        times: (N,), s.
        lengths: Leg lengths (N, 6 S), m.
        force: Net force of each ring on the torso (N, 3 S), N.
        torso: p_WT (N, 3), m; its orientation is not measured and shown as
            that at rest. None: there is no torso.

    Raises:
        KinematicsError: No pose has such lengths.
    """
    rings, X = np.empty((len(times), geometry.num_stages, 7)), None
    for pose, now in zip(rings, lengths, strict=True):
        X = find_task_coordinates(geometry, now, X)
        stages.place_rings(X, geometry.rest, pose)
    if torso is not None:
        upright = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
        torso = np.hstack([upright, torso])
    return PlaybackStates(times, rings, torso, place_on_pads(force))


def transform(pose: np.ndarray) -> RigidTransform:
    """A pose (7,) as Drake has it."""
    quaternion = pose[0:4] / np.linalg.norm(pose[0:4])
    return RigidTransform(Quaternion(quaternion), pose[4:7])
