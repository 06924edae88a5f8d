"""The host's control of a bench: the twin's own laws, tick by tick."""

from __future__ import annotations

import numpy as np

from brace_drake.kinematics import BraceGeometry
from brace_drake.laws import brace_control
from brace_drake.operation.host_control import HostControl
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.bench_brace import brace_of_bench
from brace_drake.scenario.bench_numbers import pack_bench, pack_bench_control


class PicControl(HostControl):
    """Position-based impedance control, `brace_control.advance_brace_pic`."""

    def __init__(self, scenario: BenchScenario):
        numbers = pack_bench(scenario)
        self._control = pack_bench_control(brace_of_bench(scenario), numbers)
        geometry = BraceGeometry(
            numbers.p_WB_known[None],
            numbers.p_RT_known[None],
            numbers.rest[None],
        )
        super().__init__(
            geometry, numbers.viscous, numbers.ring[4], self._control
        )
        self._WarmUp()

    def Reset(self) -> None:
        super().Reset()
        own = self._control
        self._own = own.pose.copy(), own.memory[0].copy()
        self._virtual = own.virtual.copy()

    def _SetVirtual(self, X: np.ndarray) -> None:
        self._virtual[0:6], self._virtual[6:18] = X, 0.0

    def _Advance(self, readings: np.ndarray, X_d: np.ndarray) -> None:
        result = brace_control.advance_brace_pic(
            readings[0:6], readings[6:9], X_d, self._law, *self._own,
            self._virtual, self._impedance, self.command,
        )  # fmt: skip
        self.good = result == brace_control.GOOD
