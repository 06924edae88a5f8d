"""The forces of the bench: legs, pads and posture on ring and torso."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws import blocks, legs
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.hosting import EffectHost

_POINTS = ("drive", "compression", "contact", "torso", "ring")


class BenchForces(LeafSystem):
    """Six legs between anchors, two pads, and the posture's bushing.

    Legs: f = u - viscous l', their wrench J' f. Posture: -K p - D v at To
    along W, the rotational part on the rotation vector. Pads: the paper's
    spatial contact force (`brace_drake.laws.contact`). One system, because the
    plant asks for all of it at every step.

    Input ports:
        plant_state: q, p of ring and, where present, torso; then [w; v] of
            each (13,) or (26,).
        leg_command: Held commands u (6,), N.
        contact_force: Force of the ring on the torso (3,), N, as the plant
            resolves it; only without linear pads.

    Output ports:
        generalized_force: [torque; force] of each body in W (6,) or (12,).
        measured: Leg lengths (6), m, force of the ring on the torso (3), N,
            displacement of the torso (3), m: (12,).

    Numeric parameters: `law` (60,) as `blocks.calc_bench_forces` orders it;
    those of the effects at drive, compression, contact, torso and ring, whose
    states advance once in each plant step.
    """

    def __init__(
        self,
        numbers: BenchNumbers,
        plug_ins: Mapping[str, PlugIn],
        time_step: float,
        with_torso: bool,
        with_pads: bool,
    ):
        super().__init__()
        self._dt, self._rest = time_step, numbers.rest
        self._with_torso, self._with_pads = with_torso, with_pads
        bodies = 2 if with_torso else 1
        self._state_port = self.DeclareVectorInputPort(
            "plant_state", 13 * bodies
        )
        self._command_port = self.DeclareVectorInputPort("leg_command", 6)
        self._contact_port = self.DeclareVectorInputPort("contact_force", 3)
        self._law = int(
            self.DeclareNumericParameter(BasicVector(_pack(numbers)))
        )
        self._hosts = {
            p: EffectHost(self, plug_ins.get(p) or idle(p)) for p in _POINTS
        }
        self._is_nominal = all(h.is_idle for h in self._hosts.values())
        self.DeclareVectorOutputPort(
            "generalized_force", 6 * bodies, self._CalcGeneralizedForce
        )
        # The readings must not wait for the command that they lead to.
        self.DeclareVectorOutputPort(
            "measured",
            12,
            self._CalcMeasured,
            prerequisites_of_calc={
                self._state_port.ticket(),
                self._contact_port.ticket(),
                self.all_parameters_ticket(),
                self.all_state_ticket(),
                self.time_ticket(),
            },
        )
        if not self._is_nominal:
            self.DeclarePeriodicDiscreteUpdateEvent(
                time_step, 0.0, self._AdvanceEffects
            )
        self._AllocateWork()

    def _AllocateWork(self) -> None:
        self._bodies = np.zeros(26)
        self._bodies[7] = 1.0
        self._bodies[11:14] = self._rest
        self._lengths, self._rates = np.empty(6), np.empty(6)
        self._J, self._f = np.empty((6, 6)), np.empty(6)
        self._pads, self._pose = np.empty((2, 17)), np.empty(6)
        self._F, self._f_T_W = np.zeros(12), np.zeros(3)
        self._F_R_W, self._F_T_W = self._F[0:6], self._F[6:12]
        self._measured, self._zero = np.zeros(12), np.zeros(6)

    def _LoadBodies(self, context: Context) -> None:
        state, bodies = self._state_port.Eval(context), self._bodies
        if self._with_torso:
            bodies[:] = state
        else:
            bodies[0:7] = state[0:7]
            bodies[14:20] = state[7:13]

    def _EvalNominal(self, context: Context, u: np.ndarray) -> None:
        self._LoadBodies(context)
        blocks.calc_bench_forces(
            self._bodies,
            u,
            self._with_torso,
            self._with_pads,
            self._rest,
            context.get_numeric_parameter(self._law).value(),
            self._lengths,
            self._rates,
            self._J,
            self._f,
            self._pads,
            self._pose,
            self._F_R_W,
            self._F_T_W,
            self._f_T_W,
        )

    def _EvalWithEffects(self, context: Context, u: np.ndarray):
        """The same with the effects in between; returns their states."""
        law = context.get_numeric_parameter(self._law).CopyToVector()
        memory = {p: host.memory(context) for p, host in self._hosts.items()}
        now = (context.get_time(), self._dt)
        self._LoadBodies(context)
        bodies, F_R_W, F_T_W = self._bodies, self._F_R_W, self._F_T_W
        V_WR, V_WT, pose = bodies[14:20], bodies[20:26], self._pose
        self._F[:] = 0.0
        self._f_T_W[:] = 0.0
        blocks.calc_ring_kinematics(
            bodies[0:4],
            bodies[4:7],
            V_WR,
            law[6:24].reshape(6, 3),
            law[24:42].reshape(6, 3),
            self._lengths,
            self._rates,
            self._J,
        )
        if self._with_pads:
            self._AddPads(context, law[42:48], memory)
        blocks.calc_leg_forces(u, law[0:6], self._rates, self._f)
        self._hosts["drive"].apply(
            context,
            memory["drive"],
            *now,
            u,
            self._lengths,
            self._rates,
            self._f,
        )
        legs.add_leg_wrench(self._J, self._f, F_R_W)
        p, r = pose[0:3], pose[3:6]
        blocks.calc_displacement(bodies[0:4], bodies[4:7], self._rest, pose)
        self._hosts["ring"].apply(
            context, memory["ring"], *now, p, r, V_WR, F_R_W
        )
        if self._with_torso:
            blocks.add_posture(bodies, self._rest, law[48:60], pose, F_T_W)
            self._hosts["torso"].apply(
                context, memory["torso"], *now, p, r, V_WT, F_T_W
            )
        return memory

    def _AddPads(self, context: Context, law: np.ndarray, memory) -> None:
        now = (context.get_time(), self._dt)
        for pad in range(2):
            o = self._pads[pad]
            d, N = o[14:16], o[16:17]
            blocks.calc_pad(pad, self._bodies, law, o)
            self._hosts["compression"].apply(
                context, memory["compression"], *now, pad, d
            )
            blocks.calc_pad_normal_force(law, o)
            self._hosts["contact"].apply(
                context, memory["contact"], *now, pad, d, law, N
            )
            blocks.add_pad_force(
                pad, law, o, self._F_R_W, self._F_T_W, self._f_T_W
            )

    def _CalcGeneralizedForce(
        self, context: Context, output: BasicVector
    ) -> None:
        u = self._command_port.Eval(context)
        if self._is_nominal:
            self._EvalNominal(context, u)
        else:
            self._EvalWithEffects(context, u)
        output.SetFromVector(self._F if self._with_torso else self._F_R_W)

    def _CalcMeasured(self, context: Context, output: BasicVector) -> None:
        if self._is_nominal:
            self._EvalNominal(context, self._zero)
        else:
            self._EvalWithEffects(context, self._zero)
        measured = self._measured
        measured[0:6] = self._lengths
        if self._with_pads:
            measured[6:9] = self._f_T_W
        elif self._with_torso:
            measured[6:9] = self._contact_port.Eval(context)
        if self._with_torso:
            measured[9:12] = self._bodies[11:14] - self._rest
        output.SetFromVector(measured)

    def _AdvanceEffects(self, context: Context, discrete) -> None:
        memory = self._EvalWithEffects(
            context, self._command_port.Eval(context)
        )
        for point, host in self._hosts.items():
            host.store(memory[point], discrete)


def _pack(numbers: BenchNumbers) -> np.ndarray:
    arrays = (
        numbers.viscous,
        numbers.p_WB,
        numbers.p_RT,
        numbers.contact,
        numbers.posture,
    )
    return np.concatenate([np.ravel(a) for a in arrays])
