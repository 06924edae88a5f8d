"""The section `diagram` of campaign.yaml: which column is which port's."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from brace_drake.core.errors import suggest
from brace_drake.recording.fields import HUGE, Fault, Field, number_from, take

_NUMBER = number_from(-HUGE, HUGE)
_STEP = number_from(1e-6, 1.0, required=False)


@dataclass(frozen=True)
class Ports:
    """What a campaign of a diagram says of its ports and numbers.

    Attributes:
        inputs, outputs: Columns of the elements of each exported port.
        start, start_speed: Column in which each joint's run begins.
        imposed, forces: Of a machine that is moved as it was recorded, in the
            place of ports: column of the position of each joint, and of the
            force or torque that it takes.
        numbers: What the function that makes the diagram is given.
        fitted: Limits of those that are fitted.
        deviations: One standard deviation of those known to a tolerance.
        time_step: Longest step, s; None: by the rate of the recording.
    """

    inputs: dict[str, tuple[str, ...]] = field(default_factory=dict)
    outputs: dict[str, tuple[str, ...]] = field(default_factory=dict)
    start: dict[str, str] = field(default_factory=dict)
    start_speed: dict[str, str] = field(default_factory=dict)
    imposed: dict[str, str] = field(default_factory=dict)
    forces: dict[str, str] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    fitted: dict[str, tuple[float, float]] = field(default_factory=dict)
    deviations: dict[str, float] = field(default_factory=dict)
    time_step: float | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        """All that a recording must have, each once."""
        of_ports = [*self.inputs.values(), *self.outputs.values()]
        names = [name for columns in of_ports for name in columns]
        for by_joint in (
            self.start,
            self.start_speed,
            self.imposed,
            self.forces,
        ):
            names += by_joint.values()
        return tuple(dict.fromkeys(names))

    @property
    def commands(self) -> tuple[str, ...]:
        """Columns of what is put in."""
        given = [c for names in self.inputs.values() for c in names]
        return (*given, *self.imposed.values())

    def section(self) -> dict:
        """As campaign.yaml has it; what is empty is left out."""

        def plain(value):
            if isinstance(value, dict):
                return {key: plain(item) for key, item in value.items()}
            return list(value) if isinstance(value, tuple) else value

        own = {f.name: plain(getattr(self, f.name)) for f in fields(self)}
        return {key: value for key, value in own.items() if value}


def _is_name(value) -> bool:
    return isinstance(value, str) and value.isprintable() and value != ""


def _is_map(accepts):
    """Whether a value maps names to what is accepted."""
    return lambda v: (
        isinstance(v, dict)
        and all(_is_name(k) for k in v)
        and all(accepts(item) for item in v.values())
    )


def _are_columns(value) -> bool:
    return isinstance(value, list) and value and all(map(_is_name, value))


def _are_limits(value) -> bool:
    is_pair = isinstance(value, list) and len(value) == 2
    return is_pair and all(map(_NUMBER.accepts, value)) and value[0] < value[1]


_FIELDS = {
    "inputs": Field(
        "a map of ports, each with its list of columns",
        _is_map(_are_columns),
        required=False,
    ),
    "outputs": Field(
        "a map of ports, each with its list of columns",
        lambda v: _is_map(_are_columns)(v) and v != {},
        required=False,
    ),
    **dict.fromkeys(
        ("start", "start_speed", "imposed", "forces"),
        Field(
            "a map of joints, each with its column", _is_map(_is_name), False
        ),
    ),
    "numbers": Field("a map of numbers", _is_map(_NUMBER.accepts), False),
    "fitted": Field(
        "a map of numbers, each with its limits [low, high]",
        _is_map(_are_limits),
        required=False,
    ),
    "deviations": Field(
        "a map of numbers, each with one standard deviation above 0",
        _is_map(lambda v: _NUMBER.accepts(v) and v > 0.0),
        required=False,
    ),
    "time_step": _STEP,
}


def parse_ports(section) -> tuple[Ports, list[Fault]]:
    """What the section says, and what is wrong with it."""
    if not isinstance(section, dict):
        return Ports(), [Fault("diagram", "a map with outputs", section)]
    taken, faults = take(section, _FIELDS)
    faults += _faults_of_ways(taken, section)
    names = [f.name for f in fields(Ports)]
    faults += [
        Fault(
            f"{key}{suggest(str(key), names)}",
            f"one of {', '.join(names)}",
            key,
        )
        for key in section
        if key not in names
    ]
    given = taken.get("numbers", {})
    for part in ("fitted", "deviations"):
        for name in taken.get(part, {}):
            if name not in given:
                wanted = f"one of numbers: {', '.join(given) or 'none there'}"
                faults.append(Fault(part, wanted, name))
    for name, (low, high) in taken.get("fitted", {}).items():
        if name in given and not low <= given[name] <= high:
            wanted = f"from {low:g} to {high:g}, its limits in fitted"
            faults.append(Fault(f"numbers.{name}", wanted, given[name]))
    columns = [
        column
        for part in ("inputs", "outputs")
        for names_of in taken.get(part, {}).values()
        for column in names_of
    ]
    for part in ("imposed", "forces"):
        columns += taken.get(part, {}).values()
    for column in dict.fromkeys(c for c in columns if columns.count(c) > 1):
        faults.append(Fault("columns of ports", "each once", column))
    return Ports(**_typed(taken)), [
        fault._replace(name=f"diagram.{fault.name}") for fault in faults
    ]


def _faults_of_ways(taken: dict, section: dict) -> list[Fault]:
    """A machine has ports, or joints that are moved as recorded."""
    imposed, forces = taken.get("imposed", {}), taken.get("forces", {})
    if not (imposed or forces):
        wanted = "a map of ports, each with its list of columns"
        is_told = section.get("outputs") is not None
        return [] if is_told else [Fault("outputs", wanted, None)]
    of_ports = ("inputs", "outputs", "start", "start_speed")
    faults = [
        Fault(part, "nothing beside imposed and forces", taken[part])
        for part in of_ports
        if taken.get(part)
    ]
    for part, own in (("imposed", imposed), ("forces", forces)):
        if not own:
            wanted = "a map of joints, each with its column"
            faults.append(Fault(part, wanted, None))
    for joint in forces:
        if imposed and joint not in imposed:
            wanted = f"one of imposed: {', '.join(imposed)}"
            faults.append(Fault("forces", wanted, joint))
    return faults


def _typed(taken: dict) -> dict:
    """Lists as tuples, numbers as such."""
    out = dict(taken)
    for part in ("inputs", "outputs"):
        out[part] = {k: tuple(v) for k, v in taken.get(part, {}).items()}
    for part in ("numbers", "deviations"):
        out[part] = {k: float(v) for k, v in taken.get(part, {}).items()}
    out["fitted"] = {
        k: (float(low), float(high))
        for k, (low, high) in taken.get("fitted", {}).items()
    }
    return out
