"""The forces on the bodies of a brace as a system of their own."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    OutputPort,
)
from pydrake.systems.primitives import ConstantVectorSource, Multiplexer

from brace_drake.laws.loop.brace import make_brace
from brace_drake.laws.loop.ticks import run_forces
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import PlugIn
from brace_drake.model.systems.force_laws import ForceEffects


class BraceForces(LeafSystem):
    """Legs, pads and posture of S stages: `laws.loop.forces` between ports.

    Input ports:
        inputs: Plant state, that is q, p of the rings from the lowest up and,
            where present, of the torso, then [w; v] of each (13 S) or
            (13 S + 13); held commands u (6 S), N; `BraceNumbers.force_law`.
            One port, as each costs a look-up from Python.
        contact_force: Force of each ring on the torso (3 S,), N, as far as the
            plant resolves it; unconnected it is 0.

    Output ports:
        generalized_force: [torque; force] of each body in W (6 S,) or
            (6 S + 6,).
        measured: Leg lengths (6 S), m, force of each ring on the torso (3 S),
            N, displacement of the torso (3), m.

    Without legs their forces are left out: they are bodies of the plant then.
    Effects act on each stage alike. Their parameters and states, see
    ForceEffects, are this system's; the states advance once in each plant step.
    """

    def __init__(
        self,
        numbers: BraceNumbers,
        time_step: float,
        with_torso: bool,
        with_legs: bool = True,
        plug_ins: Mapping[str, PlugIn] | None = None,
    ):
        super().__init__()
        n = self._num_stages = numbers.num_stages
        num_bodies = n + with_torso
        self._law = numbers.force_law
        self._ends = np.cumsum([7 * num_bodies, 6 * num_bodies, 6 * n])
        num_inputs = self._ends[-1] + len(self._law)
        self._port = self.DeclareVectorInputPort("inputs", num_inputs)
        self._contact_port = self.DeclareVectorInputPort("contact_force", 3 * n)
        self._hosted = ForceEffects(self, plug_ins or {}, n)
        self._DeclareOutputs(6 * num_bodies)
        if not self._hosted.is_nominal:
            self.DeclarePeriodicDiscreteUpdateEvent(
                time_step, 0.0, self._AdvanceEffects
            )
        brace = make_brace(numbers, with_torso, with_legs)
        self._poses = brace.poses[:num_bodies].reshape(-1)
        self._V = brace.V[:num_bodies].reshape(-1)
        self._u, self._F = brace.u, brace.F[:num_bodies].reshape(-1)
        self._measured = brace.readings
        self._contact = self._measured[6 * n : 9 * n]
        self._time = np.zeros(1)
        self._forces = run_forces(
            time_step,
            self._time,
            numbers.with_force_law(self._law),
            self._hosted.effects,
            brace,
        )

    def _DeclareOutputs(self, num_forces: int) -> None:
        sources = {self._port.ticket()}
        if not self._hosted.is_nominal:
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
            9 * self._num_stages + 3,
            self._CalcMeasured,
            prerequisites_of_calc=sources | {self._contact_port.ticket()},
        )

    def _Calc(self, context: Context) -> None:
        inputs = self._port.Eval(context)
        a, b, c = self._ends
        self._poses[:], self._V[:] = inputs[:a], inputs[a:b]
        self._u[:], self._law[:] = inputs[b:c], inputs[c:]
        if not self._hosted.is_nominal:
            self._hosted.load(context)
            self._time[0] = context.get_time()
        next(self._forces)

    def _CalcGeneralizedForce(
        self, context: Context, output: BasicVector
    ) -> None:
        self._Calc(context)
        output.SetFromVector(self._F)

    def _CalcMeasured(self, context: Context, output: BasicVector) -> None:
        self._Calc(context)
        if self._contact_port.HasValue(context):
            self._contact += self._contact_port.Eval(context)
        output.SetFromVector(self._measured)

    def _AdvanceEffects(self, context: Context, discrete) -> None:
        self._Calc(context)
        self._hosted.store(discrete)


def ConnectBraceForces(
    builder: DiagramBuilder,
    forces: BraceForces,
    law: np.ndarray,
    state: OutputPort,
    applied_force: InputPort,
) -> InputPort:
    """Connects forces with a plant, and adds their law as a constant.

    Native systems join what one look-up from Python then takes: at each plant
    step that is cheaper than a port for each.

    Args:
        builder: That `forces` was added to.
        forces: The system.
        law: `BraceNumbers.force_law`; a numeric parameter of the system
            `force_law`.
        state: Of the plant's rings and torso.
        applied_force: Of the plant's rings and torso.

    Returns:
        The input port for the leg commands.
    """
    add = builder.AddNamedSystem
    source = add("force_law", ConstantVectorSource(law)).get_output_port()
    num_legs = forces.GetInputPort("inputs").size() - state.size() - len(law)
    join = add("forces_inputs", Multiplexer([state.size(), num_legs, len(law)]))
    builder.Connect(join.get_output_port(), forces.GetInputPort("inputs"))
    builder.Connect(state, join.get_input_port(0))
    builder.Connect(source, join.get_input_port(2))
    builder.Connect(forces.GetOutputPort("generalized_force"), applied_force)
    return join.get_input_port(1)
