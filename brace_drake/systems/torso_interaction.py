"""Pads against torso, and the torso's posture."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws import blocks
from brace_drake.laws.plug_in import PlugIn, idle
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.hosting import EffectHost

_POINTS = ("compression", "contact", "torso")


class TorsoInteraction(LeafSystem):
    """The torso's bushing to its rest pose, and the linear pad contact.

    Posture: f = -K p - D v at To along W, the rotational part on the rotation
    vector. Contact: `brace_drake.laws.contact`, the paper's spatial contact
    force; left out where the plant itself resolves the contact.

    Input ports:
        plant_state: q_WR, p_WR, q_WT, p_WT, V_WR, V_WT (26,).

    Output ports:
        generalized_force: [torque; force] on ring and torso, W (12,).
        pad_force: Force of the ring on the torso in W (3,), N.

    Numeric parameters: contact (6,) and posture (12,), see BenchNumbers; those
    of effects at `compression`, `contact` and `torso`.
    """

    def __init__(
        self,
        numbers: BenchNumbers,
        plug_ins: Mapping[str, PlugIn],
        time_step: float,
        with_contact: bool,
    ):
        super().__init__()
        self._dt, self._rest = time_step, numbers.rest
        self._with_contact = with_contact
        self._state_port = self.DeclareVectorInputPort("plant_state", 26)
        self._contact, self._posture = (
            int(self.DeclareNumericParameter(BasicVector(a)))
            for a in (numbers.contact, numbers.posture)
        )
        self._hosts = [
            EffectHost(self, plug_ins.get(p) or idle(p)) for p in _POINTS
        ]
        self.DeclareVectorOutputPort("generalized_force", 12, self._CalcForce)
        self.DeclareVectorOutputPort("pad_force", 3, self._CalcPadForce)
        if not all(host.is_idle for host in self._hosts):
            self.DeclarePeriodicDiscreteUpdateEvent(
                time_step, 0.0, self._AdvanceEffects
            )
        self._pads, self._F = np.empty((2, 17)), np.empty(12)
        self._pose = np.empty(6)
        self._f_T_W, self._bodies = np.empty(3), np.empty(26)

    def _Eval(self, context: Context):
        self._bodies[:] = self._state_port.Eval(context)
        self._F[:] = 0.0
        memory = tuple(host.memory(context) for host in self._hosts)
        if self._with_contact:
            self._AddPads(context, memory)
        law = context.get_numeric_parameter(self._posture).CopyToVector()
        F_T_W, pose = self._F[6:12], self._pose
        blocks.add_posture(self._bodies, self._rest, law, pose, F_T_W)
        torso = self._hosts[2]
        if not torso.is_idle:
            torso.apply(
                context,
                memory[2],
                context.get_time(),
                self._dt,
                pose[0:3],
                pose[3:6],
                self._bodies[20:26],
                F_T_W,
            )
        return memory

    def _AddPads(self, context: Context, memory) -> None:
        law = context.get_numeric_parameter(self._contact).CopyToVector()
        F_R_W, F_T_W, f_T_W = self._F[0:6], self._F[6:12], self._f_T_W
        compression, contact, _ = self._hosts
        if compression.is_idle and contact.is_idle:
            blocks.add_nominal_pads(
                self._bodies, law, self._pads, F_R_W, F_T_W, f_T_W
            )
            return
        f_T_W[:] = 0.0
        now = (context.get_time(), self._dt)
        for pad in range(2):
            o = self._pads[pad]
            d, N = o[14:16], o[16:17]
            blocks.calc_pad(pad, self._bodies, law, o)
            compression.apply(context, memory[0], *now, pad, d)
            blocks.calc_pad_normal_force(law, o)
            contact.apply(context, memory[1], *now, pad, d, law, N)
            blocks.add_pad_force(pad, law, o, F_R_W, F_T_W, f_T_W)

    def _CalcForce(self, context: Context, output: BasicVector) -> None:
        self._Eval(context)
        output.SetFromVector(self._F)

    def _CalcPadForce(self, context: Context, output: BasicVector) -> None:
        self._Eval(context)
        output.SetFromVector(self._f_T_W)

    def _AdvanceEffects(self, context: Context, discrete) -> None:
        memory = self._Eval(context)
        for host, advanced in zip(self._hosts, memory, strict=True):
            host.store(advanced, discrete)
