"""The scenario of a machine that is any Drake diagram."""

from dataclasses import dataclass, field

from brace_drake.effects.card import Effect
from brace_drake.recording.columns import DIAGRAM
from brace_drake.scenario.brace import EffectUse
from brace_drake.scenario.diagram.cards import PlacedCard, place_cards
from brace_drake.scenario.fields import items, number, word


@dataclass(slots=True)
class JointSizes:
    """How far a joint of one degree of freedom moves, and its usual force."""

    kind: str = word("rotary", "linear")
    travel: float = number(0.01, "m", above=0.0)  # half of it; rad if rotary
    force: float = number(10.0, "N", above=0.0)  # N m if rotary


@dataclass(slots=True)
class BodySizes:
    """Mass of a body that moves, and how far its centre is from its frame."""

    mass: float = number(1.0, "kg", above=0.0)
    reach: float = number(0.1, "m", above=0.0)


@dataclass(slots=True)
class DiagramScenario:
    """Ports, numbers and sizes of a diagram that a function makes.

    The function, module:name, is not called by anybody who only reads this: it
    is handed over by the caller.
    """

    device: str = DIAGRAM
    diagram: str = ""
    # Columns of the elements of each port.
    inputs: dict[str, list[str]] = field(default_factory=dict)
    outputs: dict[str, list[str]] = field(default_factory=dict)
    # Columns in which joints begin a run: positions, and speeds, else 0.
    start: dict[str, str] = field(default_factory=dict)
    start_speed: dict[str, str] = field(default_factory=dict)
    # In the place of ports: columns of positions that the plant is moved
    # along, and of the forces that its joints take.
    imposed: dict[str, str] = field(default_factory=dict)
    forces: dict[str, str] = field(default_factory=dict)
    # What the function is given, by name.
    numbers: dict[str, float] = field(default_factory=dict)
    # Limits of those that every recording is fitted anew.
    fitted: dict[str, list[float]] = field(default_factory=dict)
    # One standard deviation of those that are known to a tolerance.
    deviations: dict[str, float] = field(default_factory=dict)
    # Longest step of the integration and of the effects.
    time_step: float = number(0.005, "s", above=0.0)
    # Half of the range of each column, and standard deviation of its noise.
    ranges: dict[str, float] = field(default_factory=dict)
    noise: dict[str, float] = field(default_factory=dict)
    joints: dict[str, JointSizes] = field(default_factory=dict)
    bodies: dict[str, BodySizes] = field(default_factory=dict)
    effects: list[EffectUse] = items()

    @property
    def commands(self) -> tuple[str, ...]:
        """Columns of the inputs, port after port."""
        return tuple(c for names in self.inputs.values() for c in names)

    @property
    def readings(self) -> tuple[str, ...]:
        """Columns of the outputs, port after port, or of joints' forces."""
        read = [c for names in self.outputs.values() for c in names]
        return (*read, *self.forces.values())

    @property
    def is_imposed(self) -> bool:
        """Whether the plant is moved as it was recorded."""
        return bool(self.imposed)

    def placed_cards(self) -> dict[str, PlacedCard]:
        """Effects that the machine can have, each at a place, by key."""
        sizes = (
            tuple((n, self.ranges.get(n, 1.0)) for n in self.commands),
            tuple((n, self.ranges.get(n, 1.0)) for n in self.readings),
            tuple(
                (n, j.kind, j.travel, j.force) for n, j in self.joints.items()
            ),
            tuple((n, b.mass, b.reach) for n, b in self.bodies.items()),
            tuple(self.deviations.items()),
        )
        return place_cards(*sizes, is_imposed=self.is_imposed)

    def own_effects(self) -> dict[str, Effect]:
        """Cards of those that a diagnosis may find, by key."""
        placed = self.placed_cards().items()
        return {k: p.card for k, p in placed if not p.is_tolerance}
