"""The contact force that the plant has resolved, held between its steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import GeometryId
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem

from brace_drake.systems.brace_forces import BraceForces


class ContactForceHold(LeafSystem):
    """Hydroelastic contact forces of each ring on the torso, summed, in W.

    Taken together with each plant step, when it costs no further solve and is
    that of the command in force, and held: a tick reads the force that the
    last plant step applied. The live port, read at a tick, would be solved
    with the command of the tick before. Before the first step it is 0.

    Input ports:
        contact_results: Of the plant.

    Output ports:
        contact_force: (3 S,), N, of the rings in the order given.
    """

    def __init__(self, plant: MultibodyPlant, rings: Sequence[str]):
        super().__init__()
        self._torso = _geometries(plant, "torso")
        self._row_of = {
            geometry: 3 * i
            for i, ring in enumerate(rings)
            for geometry in _geometries(plant, ring)
        }
        self._port = self.DeclareAbstractInputPort(
            "contact_results", Value[ContactResults]()
        )
        state = self.DeclareDiscreteState(3 * len(rings))
        self.DeclareStateOutputPort("contact_force", state)
        self.DeclarePeriodicDiscreteUpdateEvent(
            plant.time_step(), 0.0, self._Take
        )

    def _Take(self, context: Context, discrete) -> None:
        results = self._port.Eval(context)
        force = np.zeros(discrete.value(0).size)
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            surface = info.contact_surface()
            # F_Ac_W acts on the body of geometry M.
            f_T_W, ring = info.F_Ac_W().translational(), surface.id_N()
            if ring in self._torso:
                f_T_W, ring = -f_T_W, surface.id_M()
            if ring in self._row_of:
                row = self._row_of[ring]
                force[row : row + 3] += f_T_W
        discrete.set_value(0, force)


def _geometries(plant: MultibodyPlant, body: str) -> set[GeometryId]:
    return set(plant.GetCollisionGeometriesForBody(plant.GetBodyByName(body)))


def AddContactForce(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    rings: Sequence[str],
    forces: BraceForces,
) -> None:
    """Adds the reading of the contact forces that the plant resolves."""
    hold = builder.AddNamedSystem(
        "contact_force", ContactForceHold(plant, rings)
    )
    builder.Connect(
        plant.get_contact_results_output_port(),
        hold.GetInputPort("contact_results"),
    )
    builder.Connect(
        hold.GetOutputPort("contact_force"),
        forces.GetInputPort("contact_force"),
    )
