"""Rungs of the bench's substitution ladder."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import cont2discrete, lfilter

from brace_drake.devices.bench.force_balance import (
    CUTOFF_HZ,
    MARGIN_S,
    calc_imbalance,
    follow_ring,
)
from brace_drake.devices.bench.recorded_motion import low_pass, ring_poses
from brace_drake.devices.bench.rollout import (
    COMMANDS,
    FORCE,
    LENGTHS,
    MARKER,
    VIRTUAL,
)
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.subject import with_subject
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.isolation.block_tests import Residual, Rung
from brace_drake.isolation.phases import MotionSignals
from brace_drake.laws.loop import bench_replay, bench_tick, blocks

_FORCE_Y, _TORSO_Y = 13, 16


class _Blocks:
    """The bench's blocks, each alone: what it is fed and what it answers.

    Args:
        twin: Whose nominal numbers they have.
        rate: Of the recordings, Hz.
    """

    def __init__(self, twin: BenchTwin, rate: float):
        self._twin, self._rate, self._numbers = twin, rate, twin.numbers

    def controller(self, prepared, x):
        """Logged commands and virtual position minus the controller's."""
        out = self._run_controller(prepared, x)
        commands = self._slow(x[:, COMMANDS] - out[:, 0:6])
        scale = prepared.floor.rms
        virtual = (x[:, VIRTUAL] - out[:, 6]) / scale[VIRTUAL]
        return _always(np.concatenate([(commands / scale[0]).ravel(), virtual]))

    def _run_controller(self, prepared, x):
        numbers, rate = self._numbers, self._rate
        motion, times = prepared.motion, np.arange(len(x)) / rate
        every, settled = motion.ticks_per_sample, motion.settled_ticks
        ticks = np.arange(len(motion.desired)) - settled
        # While it settles it reads what the recording begins with.
        at = np.clip(ticks / self._twin.scenario.control.rate, 0.0, times[-1])
        readings = np.zeros((len(ticks), 12))
        readings[:, 0:9] = CubicSpline(times, x[:, 6:15])(at)
        memory = bench_tick.make_memory(numbers.rest)
        out = np.zeros((len(x) + settled // every, 7))
        bench_replay.run_controller(
            readings,
            motion.desired,
            numbers.controller_law,
            memory,
            every,
            out,
        )
        return out[settled // every :]

    def actuation(self, prepared, x):
        """Commands minus what the recorded motion and force ask for."""
        # The inner part, away from the ends that the low pass folds.
        edge = int(MARGIN_S * self._rate)
        inner = slice(edge, -edge)
        way = follow_ring(self._numbers, x, self._rate, CUTOFF_HZ)
        touches = prepared.run.contact
        imbalance = calc_imbalance(self._numbers, way, touches)
        return _always(imbalance[inner].ravel())

    def mechanism(self, prepared, x):
        """First leg lengths minus those of the ring at rest."""
        numbers = self._numbers
        lengths, rates, J = np.empty(6), np.empty(6), np.empty((6, 6))
        blocks.calc_ring_kinematics(
            np.array([1.0, 0, 0, 0]),
            numbers.rest,
            np.zeros(6),
            numbers.p_WB,
            numbers.p_RT,
            lengths,
            rates,
            J,
        )
        return _always(x[0, LENGTHS] - lengths)

    def contact(self, prepared, x):
        """Force along y minus that of the pads at the recorded places."""
        if not prepared.run.contact:
            return None
        poses, _ = self._slow_poses(x)
        relative = poses[:, 1] - self._slow(x[:, MARKER])[:, 1]
        speed = np.gradient(relative, 1.0 / self._rate)
        force = self._slow(x[:, _FORCE_Y])

        def residual(subject):
            law = with_subject(self._numbers, subject).contact
            total = np.zeros(len(x))
            for s in (1.0, -1.0):
                d, d_dot = law[5] - s * relative, -s * speed
                N = np.where(d > 0.0, law[0] * d + law[1] * d_dot, 0.0)
                total -= s * np.maximum(N, 0.0)
            return force - total

        return residual

    def torso(self, prepared, x):
        """Marker along y minus what the measured force makes of a torso."""
        if not prepared.run.contact:
            return None

        def residual(subject):
            changed = with_subject(self._numbers, subject)
            mass, stiffness, damping = (
                changed.torso[0],
                changed.posture[1],
                changed.posture[4],
            )
            system = ([1.0 / mass], [1.0, damping / mass, stiffness / mass])
            b, a, _ = cont2discrete(system, 1.0 / self._rate, method="foh")
            predicted = lfilter(np.ravel(b), a, x[:, _FORCE_Y])
            return self._slow(x[:, _TORSO_Y] - predicted)

        return residual

    def sensing(self, prepared, x):
        """Force that is read where there is nothing to press on."""
        if prepared.run.contact:
            return None
        return _always(low_pass(x[:, FORCE], 1.0, self._rate).ravel())

    def _slow_poses(self, x):
        return ring_poses(self._numbers, self._slow(x[:, LENGTHS]))

    def _slow(self, values):
        return low_pass(values, CUTOFF_HZ, self._rate)


def bench_rungs(twin: BenchTwin, rate: float) -> list[Rung]:
    """Controller, actuation, mechanism, contact, torso and sensing."""
    block, names = _Blocks(twin, rate), twin.channels
    return [
        Rung(
            "controller",
            "leg lengths, force, reference",
            "commands, virtual position",
            block.controller,
            (*names[COMMANDS], names[VIRTUAL]),
        ),
        Rung(
            "actuation",
            "commands, motion and force of the ring",
            "balance of the leg forces",
            block.actuation,
            names[COMMANDS],
        ),
        Rung(
            "mechanism",
            "rest pose of the ring",
            "leg lengths at rest",
            block.mechanism,
        ),
        Rung(
            "contact",
            "motion of ring and torso",
            "force between them",
            block.contact,
            names[MARKER],
            ("contact_stiffness_N_m", "contact_damping_N_s_m", "preload_m"),
        ),
        Rung(
            "torso",
            "force on the torso",
            "motion of the torso",
            block.torso,
            names[MARKER],
            (
                "torso_mass_kg",
                "posture_stiffness_y_N_m",
                "posture_damping_y_N_s_m",
            ),
        ),
        Rung("sensing", "no contact", "force reading", block.sensing),
    ]


def _always(residual: np.ndarray) -> Residual:
    """Of a block that has nothing of the subject."""
    return lambda subject: residual


def bench_quantities(twin: BenchTwin, x: np.ndarray) -> dict[str, np.ndarray]:
    """What a therapist asks for: pad force, N, and ring position, mm."""
    poses, _ = ring_poses(twin.numbers, x[:, LENGTHS])
    return {"force_error_N": x[:, FORCE], "ring_error_mm": 1e3 * poses[:, 0:3]}


def bench_signals(
    twin: BenchTwin, prepared: PreparedRun, subject: np.ndarray
) -> MotionSignals:
    """Signals along y of a run; a pad has lost touch where the force of the
    other one alone, 2 k d_0 and more, is measured.
    """
    x = prepared.measured
    travel, name = ring_poses(twin.numbers, x[:, LENGTHS])[0][:, 1], "ring"
    touching = None
    if prepared.run.contact:
        if prepared.run.has([twin.channels[_TORSO_Y]]).all():
            travel, name = travel - x[:, _TORSO_Y], "ring against torso"
        values = {p.name: v for p, v in zip(twin.subject, subject, strict=True)}
        alone = 2.0 * values["contact_stiffness_N_m"] * values["preload_m"]
        force = x[:, _FORCE_Y]
        touching = np.column_stack([force > -alone, force < alone])
    desired = prepared.run.channels["ring2_y_desired_m"]
    return MotionSignals(desired, _FORCE_Y, touching, travel, name)
