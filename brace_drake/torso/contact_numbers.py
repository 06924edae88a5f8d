"""Numbers of the contact between a torso and its pads."""

from __future__ import annotations

from dataclasses import dataclass

from pydrake.multibody.plant import DiscreteContactApproximation

from brace_drake.scenario.bench import Contact


@dataclass(frozen=True)
class TorsoContact:
    """Numbers of the contact.

    Attributes:
        foundation_modulus: κ, pressure over depth, N/m^3.
        dissipation: D of Hunt and Crossley, s/m; `lagged` and `similar`.
        friction: Coulomb's coefficient, at rest and sliding.
        stiction_tolerance: Sliding speed from which friction is full, m/s;
            `lagged` and `similar`.
        relaxation_time: c / k, s; `sap`.
        preload: Depth of each pad at rest, m.
        reach: Pads farther than this from the torso at rest do not meet it, m.
        points: Of a pad, across and up, see `points`; 0, 0: its whole face.
        approximation: Of Drake's discrete contact.
    """

    foundation_modulus: float
    dissipation: float = 0.0
    friction: float = 0.0
    stiction_tolerance: float = 0.005
    relaxation_time: float = 0.0
    preload: float = 0.0
    reach: float = 0.05
    points: tuple[int, int] = (0, 0)
    approximation: DiscreteContactApproximation = (
        DiscreteContactApproximation.kLagged
    )


def map_linear_contact(contact: Contact, effective_area: float) -> TorsoContact:
    """Numbers that give a scenario's linear stiffness and damping.

    The damping is that of the linear law at the preload, where there is one.

    Args:
        contact: Of the scenario.
        effective_area: A_n, the mean of the pads, m^2.
    """
    relaxation = contact.damping / contact.stiffness
    return TorsoContact(
        foundation_modulus=contact.stiffness / effective_area,
        dissipation=relaxation / contact.preload if contact.preload else 0.0,
        friction=contact.friction,
        stiction_tolerance=contact.friction_regularization,
        relaxation_time=relaxation,
        preload=contact.preload,
        points=tuple(int(n) for n in contact.pad_points),
    )
