"""Six legs as forces between anchors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws import blocks, legs
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.hosting import EffectHost


class LegDrives(LeafSystem):
    """Massless legs: f = u - viscous l', their wrench on the ring J' f.

    Input ports:
        plant_state: q, p of ring and, where present, torso; then [w; v] of
            each (13,) or (26,).
        command: Held commands u (6,), N.

    Output ports:
        generalized_force: [torque; force] at Ro in W; zero on the torso (6,)
            or (12,).
        length: (6,), m.
        force: f (6,), N.

    Numeric parameters: viscous (6,), N s/m; p_WB (18,), p_RT (18,), m; those
    of effects at the plug points `drive` and `ring`.
    """

    def __init__(
        self,
        numbers: BenchNumbers,
        plug_ins: Mapping[str, PlugIn],
        time_step: float,
        with_torso: bool,
    ):
        super().__init__()
        self._dt, self._rest = time_step, numbers.rest
        bodies = 2 if with_torso else 1
        self._velocity = slice(7 * bodies, 7 * bodies + 6)
        self._state_port = self.DeclareVectorInputPort(
            "plant_state", 13 * bodies
        )
        self._command_port = self.DeclareVectorInputPort("command", 6)
        self._viscous, self._p_WB, self._p_RT = (
            int(self.DeclareNumericParameter(BasicVector(np.ravel(a))))
            for a in (numbers.viscous, numbers.p_WB, numbers.p_RT)
        )
        self._drive = EffectHost(self, plug_ins.get("drive") or idle("drive"))
        self._ring = EffectHost(self, plug_ins.get("ring") or idle("ring"))
        self.DeclareVectorOutputPort(
            "generalized_force", 6 * bodies, self._CalcGeneralizedForce
        )
        self.DeclareVectorOutputPort("length", 6, self._CalcLength)
        self.DeclareVectorOutputPort("force", 6, self._CalcForce)
        if not (self._drive.is_idle and self._ring.is_idle):
            self.DeclarePeriodicDiscreteUpdateEvent(
                time_step, 0.0, self._AdvanceEffects
            )
        self._q_WR, self._p_WR = np.empty(4), np.empty(3)
        self._V_WR, self._J = np.empty(6), np.empty((6, 6))
        self._length, self._rate = np.empty(6), np.empty(6)
        self._force, self._tau = np.empty(6), np.zeros(6 * bodies)
        self._F_R_W = self._tau[0:6]

    def _EvalKinematics(self, context: Context) -> None:
        state = self._state_port.Eval(context)
        self._q_WR[:] = state[0:4]
        self._p_WR[:] = state[4:7]
        self._V_WR[:] = state[self._velocity]
        blocks.calc_ring_kinematics(
            self._q_WR,
            self._p_WR,
            self._V_WR,
            context.get_numeric_parameter(self._p_WB)
            .CopyToVector()
            .reshape(6, 3),
            context.get_numeric_parameter(self._p_RT)
            .CopyToVector()
            .reshape(6, 3),
            self._length,
            self._rate,
            self._J,
        )

    def _EvalForces(self, context: Context):
        self._EvalKinematics(context)
        command = self._command_port.Eval(context)
        viscous = context.get_numeric_parameter(self._viscous)
        blocks.calc_leg_forces(
            command, viscous.CopyToVector(), self._rate, self._force
        )
        memory = self._drive.memory(context)
        if not self._drive.is_idle:
            self._drive.apply(
                context,
                memory,
                context.get_time(),
                self._dt,
                command.copy(),
                self._length,
                self._rate,
                self._force,
            )
        return memory

    def _EvalWrench(self, context: Context):
        drive_memory = self._EvalForces(context)
        self._F_R_W[:] = 0.0
        legs.add_leg_wrench(self._J, self._force, self._F_R_W)
        ring_memory = self._ring.memory(context)
        if not self._ring.is_idle:
            pose = np.empty(6)
            blocks.calc_displacement(self._q_WR, self._p_WR, self._rest, pose)
            self._ring.apply(
                context,
                ring_memory,
                context.get_time(),
                self._dt,
                pose[0:3],
                pose[3:6],
                self._V_WR,
                self._F_R_W,
            )
        return drive_memory, ring_memory

    def _CalcGeneralizedForce(
        self, context: Context, output: BasicVector
    ) -> None:
        self._EvalWrench(context)
        output.SetFromVector(self._tau)

    def _CalcLength(self, context: Context, output: BasicVector) -> None:
        self._EvalKinematics(context)
        output.SetFromVector(self._length)

    def _CalcForce(self, context: Context, output: BasicVector) -> None:
        self._EvalForces(context)
        output.SetFromVector(self._force)

    def _AdvanceEffects(self, context: Context, discrete) -> None:
        drive_memory, ring_memory = self._EvalWrench(context)
        self._drive.store(drive_memory, discrete)
        self._ring.store(ring_memory, discrete)
