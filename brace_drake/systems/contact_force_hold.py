"""The contact force that the plant has resolved, held between its steps."""

from __future__ import annotations

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import Context, LeafSystem


class ContactForceHold(LeafSystem):
    """Sum of hydroelastic contact forces of the ring on the torso, in W.

    Taken together with each plant step, when it costs no further solve and is
    that of the command in force, and held: a tick reads the force that the
    last plant step applied. The live port, read at a tick, would be solved
    with the command of the tick before. Before the first step it is 0.

    Input ports:
        contact_results: Of the plant.

    Output ports:
        contact_force: (3,), N.
    """

    def __init__(self, plant: MultibodyPlant):
        super().__init__()
        self._torso = set(
            plant.GetCollisionGeometriesForBody(plant.GetBodyByName("torso"))
        )
        self._port = self.DeclareAbstractInputPort(
            "contact_results", Value[ContactResults]()
        )
        state = self.DeclareDiscreteState(3)
        self.DeclareStateOutputPort("contact_force", state)
        self.DeclarePeriodicDiscreteUpdateEvent(
            plant.time_step(), 0.0, self._Take
        )

    def _Take(self, context: Context, discrete) -> None:
        results = self._port.Eval(context)
        force = np.zeros(3)
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            # F_Ac_W acts on the body of geometry M.
            f_M_W = info.F_Ac_W().translational()
            on_torso = info.contact_surface().id_M() in self._torso
            force += f_M_W if on_torso else -f_M_W
        discrete.set_value(0, force)
