"""Rungs of the bench's substitution ladder."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import cont2discrete, lfilter

from brace_drake.gap.evaluation import PreparedRun
from brace_drake.gap.ladder import Residual, Rung, low_pass
from brace_drake.gap.phases import MotionSignals
from brace_drake.laws import bench_replay, bench_tick, blocks
from brace_drake.laws.brace_control import MASS
from brace_drake.twin.bench_twin import BenchTwin
from brace_drake.twin.subject import with_subject

_COMMANDS, _LENGTHS = slice(0, 6), slice(6, 12)
_FORCE, _MARKER, _VIRTUAL = slice(12, 15), slice(15, 18), 18
_FORCE_Y, _TORSO_Y = 13, 16
_CUTOFF_HZ = 5.0


def ring_poses(twin: BenchTwin, lengths: np.ndarray):
    """Poses (N, 6) and leg Jacobians (N, 6, 6) of measured leg lengths."""
    n = twin.numbers
    poses, jacobians = (
        np.empty((len(lengths), 6)),
        np.empty((len(lengths), 6, 6)),
    )
    bench_replay.calc_poses(
        np.ascontiguousarray(lengths), n.p_WB, n.p_RT, n.rest, poses, jacobians
    )
    return poses, jacobians


def bench_rungs(twin: BenchTwin, rate: float) -> list[Rung]:
    """Controller, actuation, mechanism, contact, torso and sensing."""
    numbers, names = twin.numbers, twin.channels

    def run_controller(prepared, x):
        motion, times = prepared.motion, np.arange(len(x)) / rate
        every, settled = motion.ticks_per_sample, motion.settled_ticks
        ticks = np.arange(len(motion.desired)) - settled
        # While it settles it reads what the recording begins with.
        at = np.clip(ticks / twin.scenario.control.rate, 0.0, times[-1])
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

    def controller_residual(prepared, x):
        out = run_controller(prepared, x)
        commands = low_pass(x[:, _COMMANDS] - out[:, 0:6], _CUTOFF_HZ, rate)
        scale = prepared.floor.rms
        virtual = (x[:, _VIRTUAL] - out[:, 6]) / scale[_VIRTUAL]
        return _always(np.concatenate([(commands / scale[0]).ravel(), virtual]))

    def balance(prepared, x):
        """Commands that the recorded motion and force ask for, minus those."""
        poses, jacobians = ring_poses(
            twin, low_pass(x[:, _LENGTHS], _CUTOFF_HZ, rate)
        )
        velocity = np.gradient(poses, 1.0 / rate, axis=0)
        acceleration = np.gradient(velocity, 1.0 / rate, axis=0)
        wrench = acceleration * numbers.control[MASS]
        wrench[:, 2] += numbers.ring[4]
        if prepared.run.contact:
            wrench[:, 0:3] += low_pass(x[:, _FORCE], _CUTOFF_HZ, rate)
        forces = np.linalg.solve(
            np.transpose(jacobians, (0, 2, 1)), wrench[..., None]
        )[..., 0]
        rates = np.einsum("nij,nj->ni", jacobians, velocity)
        asked = forces + numbers.viscous * rates
        return low_pass(x[:, _COMMANDS], _CUTOFF_HZ, rate) - asked

    def actuation_residual(prepared, x):
        # The inner part, away from the ends that the low pass folds.
        inner = slice(int(0.5 * rate), -int(0.5 * rate))
        return _always(balance(prepared, x)[inner].ravel())

    def mechanism_residual(prepared, x):
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
        return _always(x[0, _LENGTHS] - lengths)

    def contact_residual(prepared, x):
        if not prepared.run.contact:
            return None
        poses, _ = ring_poses(twin, low_pass(x[:, _LENGTHS], _CUTOFF_HZ, rate))
        relative = poses[:, 1] - low_pass(x[:, _MARKER], _CUTOFF_HZ, rate)[:, 1]
        speed = np.gradient(relative, 1.0 / rate)
        force = low_pass(x[:, 13], _CUTOFF_HZ, rate)

        def residual(subject):
            law = with_subject(numbers, subject).contact
            total = np.zeros(len(x))
            for s in (1.0, -1.0):
                d, d_dot = law[5] - s * relative, -s * speed
                N = np.where(d > 0.0, law[0] * d + law[1] * d_dot, 0.0)
                total -= s * np.maximum(N, 0.0)
            return force - total

        return residual

    def torso_residual(prepared, x):
        if not prepared.run.contact:
            return None

        def residual(subject):
            changed = with_subject(numbers, subject)
            mass, stiffness, damping = (
                changed.torso[0],
                changed.posture[1],
                changed.posture[4],
            )
            system = ([1.0 / mass], [1.0, damping / mass, stiffness / mass])
            b, a, _ = cont2discrete(system, 1.0 / rate, method="foh")
            predicted = lfilter(np.ravel(b), a, x[:, 13])
            return low_pass(x[:, 16] - predicted, _CUTOFF_HZ, rate)

        return residual

    def sensing_residual(prepared, x):
        if prepared.run.contact:
            return None
        return _always(low_pass(x[:, _FORCE], 1.0, rate).ravel())

    return [
        Rung(
            "controller",
            "leg lengths, force, reference",
            "commands, virtual position",
            controller_residual,
            (*names[_COMMANDS], names[_VIRTUAL]),
        ),
        Rung(
            "actuation",
            "commands, motion and force of the ring",
            "balance of the leg forces",
            actuation_residual,
            names[_COMMANDS],
        ),
        Rung(
            "mechanism",
            "rest pose of the ring",
            "leg lengths at rest",
            mechanism_residual,
        ),
        Rung(
            "contact",
            "motion of ring and torso",
            "force between them",
            contact_residual,
            names[_MARKER],
            ("contact_stiffness_N_m", "contact_damping_N_s_m", "preload_m"),
        ),
        Rung(
            "torso",
            "force on the torso",
            "motion of the torso",
            torso_residual,
            names[_MARKER],
            (
                "torso_mass_kg",
                "posture_stiffness_y_N_m",
                "posture_damping_y_N_s_m",
            ),
        ),
        Rung("sensing", "no contact", "force reading", sensing_residual),
    ]


def _always(residual: np.ndarray) -> Residual:
    """Of a block that has nothing of the subject."""
    return lambda subject: residual


def bench_quantities(twin: BenchTwin, x: np.ndarray) -> dict[str, np.ndarray]:
    """What a therapist asks for: pad force, N, and ring position, mm."""
    poses, _ = ring_poses(twin, x[:, _LENGTHS])
    return {"force_error_N": x[:, _FORCE], "ring_error_mm": 1e3 * poses[:, 0:3]}


def bench_signals(
    twin: BenchTwin, prepared: PreparedRun, subject: np.ndarray
) -> MotionSignals:
    """Signals along y of a run; a pad has lost touch where the force of the
    other one alone, 2 k d_0 and more, is measured.
    """
    x = prepared.measured
    travel, name = ring_poses(twin, x[:, _LENGTHS])[0][:, 1], "ring"
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
