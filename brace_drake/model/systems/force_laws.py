"""The forces of the bench with the effects in between, for a system to call."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import Context, LeafSystem

from brace_drake.laws import legs
from brace_drake.laws.loop import blocks, kernels
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.model.systems.hosting import EffectHost

_POINTS = ("drive", "compression", "contact", "torso", "ring")


class ForceLaws:
    """Six legs between anchors, two pads, and the posture's bushing.

    Legs: f = u - viscous l', their wrench J' f. Posture: -K p - D v at To
    along W, the rotational part on the rotation vector. Pads: the paper's
    spatial contact force (`brace_drake.laws.contact`).

    Declares on a LeafSystem, whose constructor is running, parameters and
    states of the effects at drive, compression, contact, torso and ring.
    """

    def __init__(
        self,
        system: LeafSystem,
        plug_ins: Mapping[str, PlugIn],
        time_step: float,
        with_pads: bool,
    ):
        self._dt, self._with_pads = time_step, with_pads
        self._hosts = {
            p: EffectHost(system, plug_ins.get(p) or idle(p)) for p in _POINTS
        }
        self.is_nominal = all(h.is_idle for h in self._hosts.values())
        self._f, self._rates = np.empty(6), np.empty(6)
        self._J, self._pads = np.empty((6, 6)), np.empty((2, 17))
        self._ring_pose = np.empty(6)

    def calc(
        self, context: Context, inputs: np.ndarray, bench: np.ndarray
    ) -> dict[str, tuple[np.ndarray, ...]]:
        """Writes forces and signals.

        Args:
            context: Of the system.
            inputs: Plant state (13,) or (26,), leg commands (6), law (63), as
                `kernels.calc_brace` takes them of one stage.
            bench: Output, see `kernels.num_forces`.

        Returns:
            States of the effects one plant step on, for `store`.
        """
        memory = {p: host.memory(context) for p, host in self._hosts.items()}
        apply = _Effects(self._hosts, memory, context, self._dt)
        state, u, rest, law = np.split(
            inputs, np.cumsum([-6 - kernels.num_law(1), 6, 3])
        )
        self._CalcWithEffects(state, u, rest, law, bench, apply)
        return memory

    def store(self, memory: dict, discrete) -> None:
        """Writes states that `calc` has returned into discrete values."""
        for point, states in memory.items():
            self._hosts[point].store(states, discrete)

    def _CalcWithEffects(self, state, u, rest, law, bench, apply) -> None:
        with_torso = len(state) == 26
        bodies = state if with_torso else kernels.add_absent_torso(state)
        F_R_W, F_T_W = bench[0:6], bench[6:12]
        lengths, rates, f = bench[12:18], self._rates, self._f
        V_WR, V_WT = bodies[14:20], bodies[20:26]
        bench[0:12], bench[18:21] = 0.0, 0.0
        blocks.calc_ring_kinematics(
            bodies[0:4],
            bodies[4:7],
            V_WR,
            law[6:24].reshape(6, 3),
            law[24:42].reshape(6, 3),
            lengths,
            rates,
            self._J,
        )
        if self._with_pads:
            self._AddPads(bodies, law[42:48], bench, apply)
        blocks.calc_leg_forces(u, law[0:6], rates, f)
        apply("drive", u, lengths, rates, law[0:6], f)
        legs.add_leg_wrench(self._J, f, F_R_W)
        pose = self._ring_pose
        blocks.calc_displacement(bodies[0:4], bodies[4:7], rest, pose)
        apply("ring", pose[0:3], pose[3:6], V_WR, F_R_W)
        if with_torso:
            pose = bench[21:27]
            blocks.add_posture(bodies, rest, law[48:60], pose, F_T_W)
            posture = law[48:60]
            apply("torso", pose[0:3], pose[3:6], V_WT, posture, F_T_W)

    def _AddPads(self, bodies, law, bench, apply) -> None:
        for pad in range(2):
            o = self._pads[pad]
            d, N = o[14:16], o[16:17]
            blocks.calc_pad(pad, bodies, law, o)
            apply("compression", pad, d)
            blocks.calc_pad_normal_force(law, o)
            apply("contact", pad, d, law, N)
            blocks.add_pad_force(
                pad, law, o, bench[0:6], bench[6:12], bench[18:21]
            )


class _Effects:
    """Calls the effects at a plug point with the time and their states."""

    def __init__(self, hosts, memory, context: Context, time_step: float):
        self._hosts, self._memory, self._context = hosts, memory, context
        self._now = (context.get_time(), time_step)

    def __call__(self, point: str, *arguments) -> None:
        self._hosts[point].apply(
            self._context, self._memory[point], *self._now, *arguments
        )
