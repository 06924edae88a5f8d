"""The paper's push, 10 mm in 12 s, in a loop of compiled laws, for tests."""

import numpy as np

from brace_drake.kinematics import BraceGeometry
from brace_drake.laws.control import brace_control
from brace_drake.laws.loop import kernels
from brace_drake.laws.loop.blocks import read_instruments
from brace_drake.laws.rigid_body import step_free_body
from brace_drake.scenario.bench_numbers import (
    BenchNumbers,
    pack_bench,
    pack_bench_brace,
)
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.control_numbers import BraceRings, pack_control
from brace_drake.scenario.controllers import BraceControl

PERIOD = 1e-3


def paper_bench() -> BenchNumbers:
    """Stage 2 with the torso of the paper's scenario, nearly free along y."""
    scenario = BenchScenario()
    scenario.torso.posture_stiffness[1] = 190.0
    scenario.torso.posture_damping[1] = 52.0
    return pack_bench(scenario)


def bench_rings(numbers: BenchNumbers) -> BraceRings:
    """The bench's ring and legs as a brace of one stage."""
    geometry = BraceGeometry(
        numbers.p_WB[None], numbers.p_RT[None], numbers.rest[None]
    )
    limit = numbers.control[brace_control.LIMIT]
    return BraceRings(geometry, numbers.ring[None, :4], limit)


def cubic(seconds, distance=-0.01, duration=12.0):
    """The cubic polynomial from rest to rest, its rate and acceleration."""
    s = np.minimum(np.asarray(seconds) / duration, 1.0)
    still = np.asarray(seconds) >= duration
    y = distance * (3 * s**2 - 2 * s**3)
    rate = np.where(still, 0.0, distance / duration * 6 * (s - s**2))
    second = np.where(still, 0.0, distance / duration**2 * (6 - 12 * s))
    return np.stack([y, rate, second], axis=-1)


def push(
    control: BraceControl, seconds=12.0, step=5e-4, stiffness=None, seed=None
):
    """Runs a controller on the bench along the cubic.

    Args:
        control: Numbers.
        seconds, step: Length of the run, step of the plant, s.
        stiffness: Asked for from outside (6,), N/m.
        seed: Of the noise of the readings; None: exact readings.

    Returns:
        X (ticks, 6), force on the torso (ticks, 3), legs (ticks, 6), virtual
        and impedance (ticks, 3, 6), all at the ticks.
    """
    bench = paper_bench()
    numbers = pack_control(control, bench_rings(bench))
    law = pack_bench_brace(BenchScenario(), bench).force_law
    state = np.zeros(26)
    state[0] = state[7] = 1.0
    state[4:7] = state[11:14] = bench.rest
    parts = state[0:4], state[4:7], state[14:20]
    torso = state[7:11], state[11:14], state[20:26]
    out, command = np.zeros(kernels.num_forces(1, True)), np.zeros(6)
    held = np.zeros(18), np.zeros(18)
    pose, memory = numbers.pose.copy(), numbers.memory.copy()
    asked = np.empty(0) if stiffness is None else np.asarray(stiffness, float)
    ticks = round(seconds / PERIOD)
    noise = np.zeros((ticks if seed is not None else 0, 12))
    if seed is not None:
        draws = np.random.default_rng(seed).normal(size=noise.shape)
        noise = draws * bench.noise_sigma
    desired = np.zeros((ticks, 3, 6))
    desired[:, :, 1] = cubic(PERIOD * np.arange(ticks))
    log = [np.empty((ticks, k)) for k in (6, 3, 6, 18, 18)]
    for tick in range(ticks):
        for sub in range(round(PERIOD / step)):
            if sub == 0:
                inputs = np.concatenate([state, command, law])
                kernels.calc_brace(inputs, 1, True, True, out)
                readings = np.concatenate([out[12:21], np.zeros(3)])
                if seed is not None:
                    read_instruments(bench.resolution, noise[tick], readings)
                result = brace_control.advance_brace(
                    numbers.kind, readings[0:6], readings[6:9],
                    desired[tick].ravel(), asked, numbers.law, pose, memory,
                    *held, command,
                )  # fmt: skip
                if result != brace_control.GOOD:
                    raise AssertionError(f"tick {tick}: result {result}")
                row = pose[7:13], out[18:21], command, *held
                for array, values in zip(log, row, strict=True):
                    array[tick] = values
            inputs = np.concatenate([state, command, law])
            kernels.calc_brace(inputs, 1, True, True, out)
            out[5] -= bench.ring[4]
            step_free_body(*parts, bench.ring, out[0:6], step)
            step_free_body(*torso, bench.torso, out[6:12], step)
    virtual, impedance = (a.reshape((-1, 3, 6)) for a in log[3:])
    return log[0], log[1], log[2], virtual, impedance
