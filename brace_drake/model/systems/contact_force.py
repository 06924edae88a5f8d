"""Contact forces that the plant has resolved: of rings, and of single pads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import GeometryId, SceneGraph
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    LeafSystem,
)
from pydrake.systems.primitives import (
    Demultiplexer,
    Gain,
    LogVectorOutput,
    Multiplexer,
    VectorLogSink,
    ZeroOrderHold,
)

from brace_drake.core.errors import BraceError
from brace_drake.model.systems.brace_forces import BraceForces

_SIDES = ("left", "right")


def AddContactForce(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    rings: Sequence[str],
    forces: BraceForces,
) -> None:
    """Adds the reading of the contact forces that the plant resolves.

    All of native systems, as it runs at each plant step. What touches a ring
    is the torso alone; the ring floats, so its generalized contact forces are
    its torque about its origin and its force, in W.

    It is taken together with each plant step, when it costs no further solve
    and is that of the command in force, and held: a tick reads the force that
    the last plant step applied. The live port, read at a tick, would be solved
    with the command of the tick before. Before the first step it is 0.
    """
    join = Multiplexer([3] * len(rings))
    join = builder.AddNamedSystem("force_on_rings", join)
    for i, ring in enumerate(rings):
        split = Demultiplexer([3, 3])
        split = builder.AddNamedSystem(f"{ring}_contact", split)
        instance = plant.GetModelInstanceByName(ring)
        builder.Connect(
            plant.get_generalized_contact_forces_output_port(instance),
            split.get_input_port(),
        )
        builder.Connect(split.get_output_port(1), join.get_input_port(i))
    size = 3 * len(rings)
    opposite = builder.AddNamedSystem("force_on_torso", Gain(-1.0, size))
    hold = ZeroOrderHold(plant.time_step(), size)
    hold = builder.AddNamedSystem("contact_force", hold)
    builder.Connect(join.get_output_port(), opposite.get_input_port())
    builder.Connect(opposite.get_output_port(), hold.get_input_port())
    builder.Connect(
        hold.get_output_port(), forces.GetInputPort("contact_force")
    )


class PadForces(LeafSystem):
    """Hydroelastic contact force of each pad on the torso, in W.

    Pads are geometries of the rings whose names end in `left_pad` or
    `right_pad`.

    Input ports:
        contact_results: Of the plant.

    Output ports:
        pad_force: Of the rings in the order given, left pad first (6 S,), N.

    Raises (in the constructor):
        BraceError: A geometry of a ring is of neither side.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
        rings: Sequence[str],
    ):
        super().__init__()
        self._torso, self._row_of = _geometries(plant, "torso"), {}
        inspector = scene_graph.model_inspector()
        for i, ring in enumerate(rings):
            for geometry in _geometries(plant, ring):
                side = _side(inspector.GetName(geometry))
                self._row_of[geometry] = 6 * i + 3 * side
        self._port = self.DeclareAbstractInputPort(
            "contact_results", Value[ContactResults]()
        )
        self.DeclareVectorOutputPort("pad_force", 6 * len(rings), self._Calc)

    def _Calc(self, context: Context, output: BasicVector) -> None:
        results = self._port.Eval(context)
        force = np.zeros(output.size())
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            surface = info.contact_surface()
            # F_Ac_W acts on the body of geometry M.
            f_T_W, pad = info.F_Ac_W().translational(), surface.id_N()
            if pad in self._torso:
                f_T_W, pad = -f_T_W, surface.id_M()
            row = self._row_of[pad]
            force[row : row + 3] += f_T_W
        output.SetFromVector(force)


def _side(name: str) -> int:
    for side, word in enumerate(_SIDES):
        if name.endswith(f"{word}_pad"):
            return side
    raise BraceError(
        f"geometry {name} of a ring is no pad of a side; allowed: a name that"
        " ends in left_pad or right_pad"
    )


def _geometries(plant: MultibodyPlant, body: str) -> set[GeometryId]:
    return set(plant.GetCollisionGeometriesForBody(plant.GetBodyByName(body)))


def AddPadForceLog(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    rings: Sequence[str],
    period: float,
) -> VectorLogSink:
    """Adds a log of the forces of single pads, every `period`, s.

    A sample is of the plant step that begins at its time.
    """
    scene_graph = builder.GetSubsystemByName("scene_graph")
    pads = PadForces(plant, scene_graph, rings)
    pads = builder.AddNamedSystem("pad_forces", pads)
    builder.Connect(
        plant.get_contact_results_output_port(), pads.get_input_port()
    )
    sink = LogVectorOutput(pads.get_output_port(), builder, period)
    sink.set_name("pad_log")
    return sink
