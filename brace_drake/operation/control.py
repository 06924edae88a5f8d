"""The host's control of a bench: the twin's own laws, tick by tick."""

from __future__ import annotations

import numpy as np

from brace_drake.hardware.release import remaining
from brace_drake.laws import controller
from brace_drake.laws.force_left import calc_forces_left
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.bench_numbers import hold_forces, pack_bench

# Places in an estimate: q_WR and p_WR, [w; v].
_POSE = np.array([[15, 16, 17, 18, 12, 13, 14]])
_VELOCITY = np.array([[9, 10, 11, 6, 7, 8]])


class PicControl:
    """Position-based impedance control, `laws.controller.control_tick`.

    Attributes:
        command: Leg commands of the last tick (6,), N.
        expected: What the legs left for the torso in it (3,), N.
        good: Whether a ring pose fitted the lengths.
    """

    def __init__(self, scenario: BenchScenario):
        numbers = pack_bench(scenario)
        self.hold = hold_forces(numbers)
        self.period = 1.0 / scenario.control.rate
        self._numbers, self._law = numbers, numbers.controller_law
        self.expected = np.zeros(3)
        self.Reset()
        # Laws are loaded at their first call, which no tick could wait for.
        at_rest = np.zeros(12)
        at_rest[0:6] = np.linalg.norm(
            numbers.p_RT_known + numbers.rest - numbers.p_WB_known, axis=1
        )
        self.Tick(at_rest, np.zeros(3))
        self.Reset()

    def Reset(self) -> None:
        """Filters at 0, ring at rest: as before any motion."""
        memory = np.zeros(controller.NUM_MEMORY)
        memory[0:3], memory[3] = self._numbers.rest, 1.0
        self._memory, self._estimate = memory, np.zeros(19)
        self._away, self._homing = np.zeros(6), (0, 0)
        self.command, self.good = np.array(self.hold), True

    def GoHome(self, ticks: int) -> None:
        """Lets the next ticks bring the ring to rest from where it is found.

        X is held at X_0 r(t / T), r as in a release, so that a ring that was
        pushed away comes back softly.
        """
        self._away, self._homing = None, (0, ticks)

    def Tick(self, readings: np.ndarray, desired: np.ndarray) -> np.ndarray:
        """Takes a tick's readings (12,) and y_d, y_d', y_d''; returns (6,)."""
        numbers, held = self._numbers, self.command.copy()
        done, ticks = self._homing
        if done < ticks:
            self._TickHome(readings, desired)
        else:
            self.good = controller.control_tick(
                readings, desired, self._law, self._memory, self._estimate,
                self.command,
            )  # fmt: skip
        estimate = self._estimate
        calc_forces_left(
            estimate[_POSE], estimate[_VELOCITY], held, numbers.viscous,
            numbers.ring[4:5], numbers.p_WB_known[None],
            numbers.p_RT_known[None], self.expected,
        )  # fmt: skip
        return self.command

    def _TickHome(self, readings: np.ndarray, desired: np.ndarray) -> None:
        numbers, estimate = self._numbers, self._estimate
        anchors = numbers.p_WB_known, numbers.p_RT_known
        pose = self._memory[: controller.NUM_POSE_MEMORY]
        virtual = self._memory[controller.NUM_POSE_MEMORY :]
        self.good = controller.estimate_pose(
            readings[0:6], numbers.estimator, *anchors, pose, estimate
        )
        controller.filter_impedance(
            readings[7], desired, numbers.impedance, virtual
        )
        if self._away is None:
            self._away = estimate[0:6].copy()
            # A pose found at once is no velocity.
            pose[13:19], estimate[6:12] = 0.0, 0.0
        done, ticks = self._homing
        self._homing = done + 1, ticks
        shifted = estimate.copy()
        shifted[0:6] -= remaining(done, ticks) * self._away
        self.good = self.good and controller.calc_leg_commands(
            shifted, virtual, numbers.inverse_dynamics, *anchors, self.command
        )

    def Pass(self, command) -> None:
        """Tells what the legs were given in place of the last command."""
        self.command[:] = command

    @property
    def pose(self) -> list[float]:
        """X of the ring (6,)."""
        return self._estimate[0:6].tolist()

    @property
    def virtual(self) -> list[float]:
        """X_v of the ring (6,)."""
        return [0.0, float(self.y_virtual[0]), 0.0, 0.0, 0.0, 0.0]

    @property
    def stiffness(self) -> np.ndarray:
        """K_d along y (1,), N/m."""
        return self._numbers.impedance[2:3]

    @property
    def y_ring(self) -> np.ndarray:
        """Displacement along y (1,), m."""
        return self._estimate[1:2].copy()

    @property
    def y_virtual(self) -> np.ndarray:
        """Virtual position along y (1,), m."""
        at = controller.NUM_POSE_MEMORY + 1
        return self._memory[at : at + 1].copy()
