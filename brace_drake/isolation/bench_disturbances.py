"""Responses of the bench's closed loop to small errors in each block."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.bench.rollout import LENGTHS
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.laws.loop.disturbance import (
    COUNTS,
    LAWS,
    NUM_COEFFICIENTS,
    NUM_STATES,
)

GENERIC = Effect(
    name="disturbance",
    block="actuation",
    title="any small error of a block",
    equation="see laws.disturbance",
    source="this package",
    parameters=(),
    laws=LAWS,
    num_states=NUM_STATES,
    signature="",
    impostors={},
    experiment="",
)

# Small against what a block does, large against rounding; in the order of
# `laws.disturbance.COUNTS`.
_SIZES = {
    "actuation": [1e-2, 1e-4, 1e-2, 0.1, 1.0, 1e-2, 10.0, *[1e-2] * 7],
    "mechanism": [1e-2, 10.0, 10.0, 1e3, 1.0],
    "contact": [1e4, 1e6, 1e3, 50.0, 50.0, 50.0, 1e-2, 1e-2],
    "torso": [1e3, 1e5, 20.0, 20.0, 1e-2, *[1e-6] * 8],
    "sensing": [1e-2, 1e-2, 1e-2, 1e-3, 1e-2, 1e-2, 1e-4, *[1e-6] * 6],
}
# Coefficients that every run has its own of: what depends on time alone.
_OWN = {"torso": range(5, 13)}
# Without a torso these blocks do nothing.
_NEED_TORSO = ("contact", "torso")
_CUTOFF_HZ = 20.0
# Anchor errors that are tried: of the moving ring's anchors, each axis, m.
_ANCHOR = 1e-6


def disturbances(
    device_runs: list[PreparedRun], evaluator: Evaluator, subject: np.ndarray
) -> dict[str, list[list[np.ndarray | None]]]:
    """Weighted responses to one small error after the other.

    Args:
        device_runs: Runs to look at.
        evaluator: Whose coarse twin answers.
        subject: Where the twin stands.

    Returns:
        For each block one list per error, of the weighted change in each
        run, None where there is none.
    """
    twin = evaluator.twin.coarse()
    bases = [twin.simulate(p.motion, subject) for p in device_runs]
    generic, tasks = _points(), []
    recorded = [_recorded_rates(p) for p in device_runs]
    for block, uses, own in generic:
        idle = [block in _NEED_TORSO and not p.run.contact for p in device_runs]
        tasks.append((block, uses, own, idle))

    def one(i, block, uses, idle):
        if idle:
            return None
        (effect, p), *_ = uses
        if effect is GENERIC:
            uses = ((effect, np.concatenate([p, recorded[i]])),)
        try:
            moved = twin.simulate(device_runs[i].motion, subject, uses)
        except BraceError:
            return None
        return device_runs[i].weigh(moved - bases[i])

    jobs = [
        (i, block, uses, idle[i])
        for block, uses, _, idle in tasks
        for i in range(len(device_runs))
    ]
    answers = iter(evaluator.map(one, jobs))
    out: dict[str, list] = {block: [] for block in COUNTS}
    for block, _, own, _ in tasks:
        changes = [next(answers) for _ in device_runs]
        if not own:
            out[block].append(changes)
            continue
        for i, change in enumerate(changes):
            if change is not None:
                alone = [None] * len(changes)
                alone[i] = change
                out[block].append(alone)
    return out


def _recorded_rates(prepared: PreparedRun) -> np.ndarray:
    """Recording rate, Hz, and leg rates of a run, m/s, as p has them."""
    time = prepared.run.time_s
    rate = (len(time) - 1) / (time[-1] - time[0])
    lengths = low_pass(prepared.measured[:, LENGTHS], _CUTOFF_HZ, rate)
    rates = np.gradient(lengths, 1.0 / rate, axis=0)
    return np.concatenate([[rate], rates.ravel()])


def _points() -> list[tuple]:
    """Block, effects in use, and whether each run has its own of it."""
    points, at = [], 0
    for block, count in COUNTS.items():
        for j in range(count):
            p = np.zeros(NUM_COEFFICIENTS)
            p[at + j] = _SIZES[block][j]
            own = j in _OWN.get(block, ())
            points.append((block, ((GENERIC, p),), own))
        at += count
    compliance = find_effect("leg_compliance")
    values = compliance.starts()[0]
    points.append(("mechanism", ((compliance, values),), False))
    anchors = find_effect("anchor_error")
    for i in range(18):
        values = np.zeros(len(anchors.parameters))
        values[18 + i] = _ANCHOR
        points.append(("mechanism", ((anchors, values),), False))
    return points
