"""A bench with wider joint circles, recorded by its own twin."""

from __future__ import annotations

import numpy as np

from brace_drake.devices.bench.rollout import Motion
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.reference import COLUMNS, reference_at_ticks
from brace_drake.scenario.brace import BenchScenario


def record_wider(
    table: dict[str, np.ndarray], contact: bool, seed: int
) -> None:
    """Puts what a wider bench records on the same reference into a table."""
    scenario = BenchScenario()
    twin = BenchTwin(scenario, 1e-3 / 3.0)
    shift = np.array([1.25, 1.25, 1.0])
    numbers = twin.numbers
    twin.numbers = numbers.with_changes(lower=numbers.lower * shift)
    control = twin.numbers.control.copy()
    lower = control[11:14].reshape(6, 3) * shift
    control[11:14] = lower.reshape(3, 6)
    twin.numbers = twin.numbers.with_changes(control=control)
    time = table["time_s"] - table["time_s"][0]
    samples = np.column_stack([table[c] for c in COLUMNS])
    desired = reference_at_ticks(time, samples, 1000.0)
    subject = np.array([p.nominal for p in twin.subject])
    log = twin.simulate(
        Motion(desired, contact), subject, (), np.random.default_rng(seed)
    )
    for name, values in zip(twin.channels, log.T, strict=True):
        if name in table:
            table[name] = values
