"""The paper's push, 10 mm in 12 s, in a loop of compiled laws, for tests."""

import numpy as np

from brace_drake.laws.control import brace_control
from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.ticks import run_ticks
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import make_effects
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import geometry_of, pack_bench
from brace_drake.scenario.control_numbers import BraceRings, pack_control
from brace_drake.scenario.controllers import BraceControl

PERIOD = 1e-3


def paper_bench() -> BraceNumbers:
    """Stage 2 with the torso of the paper's scenario, nearly free along y."""
    scenario = BenchScenario()
    scenario.torso.posture_stiffness[1] = 190.0
    scenario.torso.posture_damping[1] = 52.0
    return pack_bench(scenario)


def bench_rings(numbers: BraceNumbers) -> BraceRings:
    """The bench's ring and legs as a brace of one stage."""
    limit = numbers.control[brace_control.LIMIT]
    return BraceRings(geometry_of(numbers), numbers.ring[:, :4], limit)


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
    held = (
        numbers.pose.copy(), numbers.memory.copy(), numbers.virtual.copy(),
        np.zeros(18),
    )  # fmt: skip
    asked = np.empty(0) if stiffness is None else np.asarray(stiffness, float)
    ticks, noise = round(seconds / PERIOD), np.full(12, np.nan)
    draws = np.random.default_rng(seed).normal(size=(ticks, 12))
    desired = np.zeros((ticks, 3, 6))
    desired[:, :, 1] = cubic(PERIOD * np.arange(ticks))
    brace, effects = make_brace(bench, with_torso=True), make_effects({}, 1)
    steps = round(PERIOD / step)
    plant = run_ticks(step, steps, bench, effects, brace, noise)
    log = [np.empty((ticks, k)) for k in (6, 3, 6, 18, 18)]
    for tick in range(ticks):
        if seed is not None:
            noise[:] = draws[tick] * bench.noise_sigma
        next(plant)
        result = brace_control.advance_brace(
            numbers.kind, numbers.law, held, brace.readings,
            desired[tick].ravel(), asked, brace.u,
        )  # fmt: skip
        if result != brace_control.GOOD:
            raise AssertionError(f"tick {tick}: result {result}")
        row = held[0][7:13], brace.f_T[0], brace.u, *held[2:]
        for array, values in zip(log, row, strict=True):
            array[tick] = values
    virtual, impedance = (a.reshape((-1, 3, 6)) for a in log[3:])
    return log[0], log[1], log[2], virtual, impedance
