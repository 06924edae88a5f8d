"""Small errors of the bench's blocks, which its closed loop answers."""

from __future__ import annotations

from functools import partial

import numpy as np

from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.bench.rollout import LENGTHS
from brace_drake.devices.declaration import SmallError
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect
from brace_drake.effects.stack import Use
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
# `laws.loop.disturbance.COUNTS`.
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


def bench_errors() -> list[SmallError]:
    """Each coefficient of `laws.loop.disturbance`, elastic legs, and each
    anchor of the moving ring along each axis.
    """
    errors = []
    for block, count in COUNTS.items():
        for j in range(count):
            coefficients = np.zeros(NUM_COEFFICIENTS)
            # Those of one block lie behind those of the blocks before.
            coefficients[len(errors)] = _SIZES[block][j]
            uses = partial(_generic_uses, block, coefficients)
            is_own = j in _OWN.get(block, ())
            errors.append(SmallError(block, uses, is_own))
    compliance, anchors = map(find_effect, ("leg_compliance", "anchor_error"))
    others = [(compliance, compliance.starts()[0])]
    for values in _ANCHOR * np.eye(len(anchors.parameters))[18:]:
        others.append((anchors, values))
    return errors + [
        SmallError("mechanism", lambda prepared, use=use: [use])
        for use in others
    ]


def _generic_uses(block: str, coefficients: np.ndarray, prepared) -> list[Use]:
    """An error of a block in a run: its coefficients, then the recording's
    rate, Hz, and rates of the legs, m/s, as `laws.loop.disturbance` has them.
    """
    if block in _NEED_TORSO and not prepared.run.contact:
        return []
    time = prepared.run.time_s
    rate = (len(time) - 1) / (time[-1] - time[0])
    lengths = low_pass(prepared.measured[:, LENGTHS], _CUTOFF_HZ, rate)
    rates = np.gradient(lengths, 1.0 / rate, axis=0)
    return [(GENERIC, np.concatenate([coefficients, [rate], rates.ravel()]))]
