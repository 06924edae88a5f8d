"""A plant that is moved as it was recorded, and the forces that this takes.

    tau = M(q) q'' + C(q, q') q' - tau_g(q) + friction and springs

(Featherstone, Rigid Body Dynamics Algorithms, chapter 5). No controller need be
known, and nothing drifts.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.tree import MultibodyForces
from scipy.interpolate import LSQUnivariateSpline

from brace_drake.devices.axis.twin import simulate_axis
from brace_drake.devices.diagram.model import DiagramModel
from brace_drake.devices.diagram.rollout import read_log, uses_by_place
from brace_drake.devices.diagram.twin import DiagramTwin
from brace_drake.effects.signal.ways import READING
from brace_drake.recording.recording import Run
from brace_drake.scenario.axis.units import FORCE_N, LENGTH_M
from brace_drake.scenario.diagram import DiagramScenario, JointSizes
from brace_drake.scenario.diagram.cards import JOINT
from brace_drake.scenario.pad_noise import estimate_white_noise

# Of a path: it has a continuous acceleration, and knows none at its ends. No
# reading is better than this part of its range.
_DEGREE, _FINEST = 5, 1e-6
_ROWS_OF_A_PIECE = 3
# Pieces are as many more from trial to trial; residuals of noise alone are so
# many times its variance at most.
_MORE, _AT_NOISE = 1.3, 1.1
# Pieces at each end that the forces fade in over.
_ENDS = 2
# A joint that does not move has a size all the same.
_LEAST = 1e-6
# Law of an axis that takes no force by itself.
_NO_LAW = np.zeros(4)


@dataclass(frozen=True)
class JointPath:
    """How one joint was moved: a spline of fifth degree through its readings.

    Attributes:
        time: From 0 (N,), s.
        position: As recorded (N,).
        knots: Inner ones, half as far apart as those that leave no more than
            the readings' noise (de Boor, A Practical Guide to Splines, chapter
            14).
    """

    time: np.ndarray
    position: np.ndarray
    knots: np.ndarray

    def path(self, noise: np.ndarray | None = None) -> np.ndarray:
        """Position, speed and acceleration (N, 3).

        Args:
            noise: Added to the recorded position (N,).
        """
        read = self.position if noise is None else self.position + noise
        spline = LSQUnivariateSpline(self.time, read, self.knots, k=_DEGREE)
        return np.column_stack([spline(self.time, nu) for nu in range(3)])


def MakeJointPath(
    time: np.ndarray, position: np.ndarray, sigma: float
) -> JointPath:
    """The path of recorded times, s, and positions, (N,) each.

    Args:
        time, position: Of the run.
        sigma: Standard deviation of a reading.
    """
    since = time - time[0]
    most = max(1, len(since) // _ROWS_OF_A_PIECE)
    least = max(sigma, _FINEST * float(np.ptp(position)), 1e-12)
    pieces = 4
    while pieces < most:
        knots = _even_knots(since, pieces)
        spline = LSQUnivariateSpline(since, position, knots, k=_DEGREE)
        free = len(since) - pieces - _DEGREE
        if spline.get_residual() <= _AT_NOISE * free * least**2:
            break
        pieces = math.ceil(_MORE * pieces)
    # With so few it is as far off as the noise is; with twice as many by little
    # of it.
    knots = _even_knots(since, min(2 * pieces, most))
    return JointPath(since, np.array(position, dtype=float), knots)


def _even_knots(time: np.ndarray, pieces: int) -> np.ndarray:
    """Between even pieces: noise is then the same everywhere."""
    return np.linspace(time[0], time[-1], pieces + 1)[1:-1]


@dataclass(frozen=True)
class ImposedMotion:
    """How joints were moved.

    Attributes:
        period: Between two samples, s.
        ways: Of each joint.
    """

    period: float
    ways: Mapping[str, JointPath]

    def paths(self, noise: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Position, speed and acceleration of each joint (N, 3).

        Args:
            noise: Added to recorded positions; those that have none are taken
                as they are.
        """
        return {n: way.path(noise.get(n)) for n, way in self.ways.items()}

    def trust(self) -> np.ndarray:
        """Weight of each sample, 0 to 1 (N, 1): a spline knows little of the
        acceleration in its first and last pieces.
        """
        time = next(iter(self.ways.values())).time
        knots = [w.knots for w in self.ways.values() if len(w.knots) > _ENDS]
        first = max((k[_ENDS - 1] for k in knots), default=0.0)
        last = min((k[-_ENDS] for k in knots), default=time[-1])
        way = np.minimum(time, time[-1] - time)
        length = max(first, time[-1] - last, 1e-9)
        return np.sin(0.5 * np.pi * np.clip(way / length, 0.0, 1.0))[:, None]


class ImposedTwin(DiagramTwin):
    """Moves the plant of a diagram along recorded positions."""

    def motion(self, run: Run) -> ImposedMotion:
        """The run's positions, speeds and accelerations."""
        columns, noise = self.scenario.imposed, self.scenario.noise
        ways = {
            joint: MakeJointPath(
                run.time_s, run.channels[column], noise.get(column, 0.0)
            )
            for joint, column in columns.items()
        }
        return ImposedMotion(float(np.median(np.diff(run.time_s))), ways)

    def measured(self, run: Run) -> np.ndarray:
        """Recorded forces, as far as the motion is known (N, J)."""
        return self.trust(self.motion(run)) * self.written(run)

    def written(self, run: Run) -> np.ndarray:
        return super().measured(run)

    def trust(self, motion: ImposedMotion) -> np.ndarray:
        """See `ImposedMotion.trust` (N, 1)."""
        return motion.trust()

    def _replay(self, numbers, motion, subject, uses, generator):
        """What joints take, and what is read of it; noise of positions goes
        through their smoothing.
        """
        scenario, noise = self.scenario, {}
        if generator is not None:
            for joint, column in scenario.imposed.items():
                size = len(motion.ways[joint].time)
                sigma = scenario.noise.get(column, 0.0)
                noise[joint] = sigma * generator.standard_normal(size)
        paths = motion.paths(noise)

        def taken():
            with self._models.of(numbers.values) as model:
                model.reset(numbers.payloads)
                return CalcForces(model, paths, scenario.forces)

        # What the plant itself takes is the same with any friction.
        key: Hashable = None
        if generator is None:
            places = tuple(p[:, 0].tobytes() for p in paths.values())
            values = tuple(numbers.values.items())
            key = (values, tuple(sorted(numbers.payloads.items())), places)
        log = taken() if key is None else self._memory.recall(key, taken)
        log = log + self._at_joints(motion, paths, uses)
        if any(
            scenario.placed_cards()[e.key].place == READING for e, _ in uses
        ):
            log = read_log(scenario, motion, log, uses)
        return motion.trust() * self._with_noise(log, generator)

    def _at_joints(self, motion: ImposedMotion, paths, uses) -> np.ndarray:
        """What effects at joints take (N, J)."""
        scenario = self.scenario
        own = uses_by_place(scenario, uses)[JOINT]
        columns = []
        for joint in scenario.forces:
            size = scenario.joints[joint]
            length, force = size.travel / LENGTH_M, size.force / FORCE_N
            time, path = motion.ways[joint].time, paths[joint] / length
            none = np.zeros((len(time), 0))
            columns.append(
                force
                * simulate_axis(
                    _NO_LAW, time, path, none, self.time_step, own[joint]
                )
                if joint in own
                else np.zeros(len(time))
            )
        return np.column_stack(columns)


def CalcForces(
    model: DiagramModel,
    paths: Mapping[str, np.ndarray],
    joints: Mapping[str, str],
) -> np.ndarray:
    """Forces and torques that joints take of what moves them (N, J).

    Args:
        model: Begun anew; joints without a path stay where they begin.
        paths: Position, speed and acceleration of joints (N, 3).
        joints: Those whose forces are wanted.
    """
    plant, context = model.plant, model.plant_context
    samples = len(next(iter(paths.values())))
    q = np.tile(plant.GetPositions(context), (samples, 1))
    v = np.zeros((samples, plant.num_velocities()))
    acceleration = np.zeros_like(v)
    for name, path in paths.items():
        joint = model.joints[name]
        q[:, joint.position] = path[:, 0]
        v[:, joint.velocity] = path[:, 1]
        acceleration[:, joint.velocity] = path[:, 2]
    wanted = [model.joints[name].velocity for name in joints]
    log, own = np.zeros((samples, len(wanted))), MultibodyForces(plant)
    for i in range(samples):
        plant.SetPositions(context, q[i])
        plant.SetVelocities(context, v[i])
        plant.CalcForceElementsContribution(context, own)
        taken = plant.CalcInverseDynamics(context, acceleration[i], own)
        log[i] = taken[wanted]
    return log


def take_imposed_sizes(scenario: DiagramScenario, runs, kinds) -> None:
    """Sizes of joints, and noise of positions, as runs show them.

    Args:
        scenario: Its columns; changed.
        runs: That are fitted.
        kinds: Joints of the plant by name.
    """
    for name, column in scenario.imposed.items():
        ways = [run.channels[column] for run in runs]
        scenario.noise[column] = estimate_white_noise(ways)
        travel = 0.5 * float(np.ptp(np.concatenate(ways)))
        force = scenario.forces.get(name)
        if force is None:
            continue
        every = np.concatenate([run.channels[force] for run in runs])
        kind = "rotary" if kinds[name].is_rotary else "linear"
        size = float(np.sqrt(np.mean(every**2)))
        scenario.joints[name] = JointSizes(
            kind, max(travel, _LEAST), max(size, _LEAST)
        )
