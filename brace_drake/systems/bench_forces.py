"""The forces of the bench as a system of their own."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.laws import kernels
from brace_drake.laws.plug_in import PlugIn
from brace_drake.scenario.bench_numbers import BenchNumbers
from brace_drake.systems.force_laws import ForceLaws


def pack_bench_law(numbers: BenchNumbers) -> np.ndarray:
    """The law of a bench's forces, see `kernels.NUM_BENCH_LAW`."""
    arrays = (
        numbers.rest,
        numbers.viscous,
        numbers.p_WB,
        numbers.p_RT,
        numbers.contact,
        numbers.posture,
    )
    return np.concatenate([np.ravel(a) for a in arrays])


class BenchForces(LeafSystem):
    """Legs, pads and posture: ForceLaws between ports.

    Input ports:
        inputs: Plant state, that is q, p of ring and, where present, torso,
            then [w; v] of each (13) or (26); held commands u (6), N; law (63),
            see `kernels.NUM_BENCH_LAW`. One port, as each costs a look-up
            from Python.
        contact_force: Force of the ring on the torso (3,), N, as the plant
            resolves it; only without linear pads.

    Output ports:
        generalized_force: [torque; force] of each body in W (6,) or (12,).
        measured: Leg lengths (6), m, force of the ring on the torso (3), N,
            displacement of the torso (3), m: (12,).

    Parameters and states of the effects, see ForceLaws, are this system's;
    the states advance once in each plant step.
    """

    def __init__(
        self,
        plug_ins: Mapping[str, PlugIn],
        time_step: float,
        with_torso: bool,
        with_pads: bool,
    ):
        super().__init__()
        self._takes_contact = with_torso and not with_pads
        num_inputs = 13 * (1 + with_torso) + 6 + kernels.NUM_BENCH_LAW
        self._port = self.DeclareVectorInputPort("inputs", num_inputs)
        self._contact_port = self.DeclareVectorInputPort("contact_force", 3)
        self._with_pads = with_pads
        self._laws = ForceLaws(self, plug_ins, time_step, with_pads)
        self._DeclareOutputs(6 * (1 + with_torso))
        if not self._laws.is_nominal:
            self.DeclarePeriodicDiscreteUpdateEvent(
                time_step, 0.0, self._AdvanceEffects
            )
        self._bench = np.zeros(kernels.NUM_BENCH_WITH_WORK)
        self._F = self._bench[0 : 6 * (1 + with_torso)]
        self._measured = self._bench[12:24]

    def _DeclareOutputs(self, num_forces: int) -> None:
        sources = {self._port.ticket()}
        if not self._laws.is_nominal:
            sources |= {
                self.all_parameters_ticket(),
                self.all_state_ticket(),
                self.time_ticket(),
            }
        self.DeclareVectorOutputPort(
            "generalized_force",
            num_forces,
            self._CalcGeneralizedForce,
            prerequisites_of_calc=sources,
        )
        # At a tick the held command is still the last one's, which the
        # measured signals do not depend on.
        self.DeclareVectorOutputPort(
            "measured",
            12,
            self._CalcMeasured,
            prerequisites_of_calc=sources | {self._contact_port.ticket()},
        )

    def _Calc(self, context: Context) -> None:
        inputs = self._port.Eval(context)
        if self._laws.is_nominal:
            kernels.calc_bench(inputs, self._with_pads, self._bench)
        else:
            self._laws.calc(context, inputs, self._bench)

    def _CalcGeneralizedForce(
        self, context: Context, output: BasicVector
    ) -> None:
        self._Calc(context)
        output.SetFromVector(self._F)

    def _CalcMeasured(self, context: Context, output: BasicVector) -> None:
        self._Calc(context)
        if self._takes_contact:
            self._measured[6:9] = self._contact_port.Eval(context)
        output.SetFromVector(self._measured)

    def _AdvanceEffects(self, context: Context, discrete) -> None:
        inputs = self._port.Eval(context)
        memory = self._laws.calc(context, inputs, self._bench)
        self._laws.store(memory, discrete)
