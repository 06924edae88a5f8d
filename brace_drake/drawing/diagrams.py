"""Graphs of Drake's diagrams, of single systems in them, and of plants."""

from __future__ import annotations

from collections.abc import Sequence

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex, RigidBody
from pydrake.systems.framework import Diagram, PortDataType, System

from brace_drake.drawing.graph import Box, Graph, Wire


def make_system_graph(diagram: Diagram) -> Graph:
    """All systems of a diagram with the ports that are in use."""
    graph = Graph(diagram.get_name())
    systems = diagram.GetSystems()
    pairs = _connections(diagram)
    used = {(s, "in", p) for _, _, s, p in pairs}
    used |= {(s, "out", p) for s, p, _, _ in pairs}
    entering, leaving = _exported(diagram)
    used |= {(s, "in", p) for _, s, p in entering}
    used |= {(s, "out", p) for _, s, p in leaving}
    rows = {}
    for system in systems:
        box, ports = _make_box(system, used)
        rows[system] = graph.add(box), ports
    for source, output, target, port in pairs:
        graph.wires.append(_wire(rows, source, output, target, port))
    for label, target, port in entering:
        at = graph.add(Box(label, outputs=("",), kind="port"))
        box, ports = rows[target]
        graph.wires.append(Wire(at, 0, box, ports["in", port]))
    for label, source, port in leaving:
        at = graph.add(Box(label, inputs=("",), kind="port"))
        box, ports = rows[source]
        graph.wires.append(Wire(box, ports["out", port], at, 0))
    return graph


def make_part_graph(diagram: Diagram, system: System) -> Graph:
    """One system with all its ports, between what feeds and what reads it."""
    graph = Graph(f"{diagram.get_name()}: {system.get_name()}")
    entering, leaving = _exported(diagram)
    sources, targets = {}, {}
    for source, output, target, port in _connections(diagram):
        if target is system:
            sources[port] = source.get_name(), _label_output(source, output)
        if source is system:
            name = target.get_name(), _label_input(target, port)
            targets.setdefault(output, []).append(name)
    sources |= {p: (label, None) for label, s, p in entering if s is system}
    for label, s, p in leaving:
        if s is system:
            targets.setdefault(p, []).append((label, None))
    centre = graph.add(_make_whole_box(system, sources, targets))
    for port, end in sources.items():
        at = graph.add(_make_end(*end, "outputs"))
        graph.wires.append(Wire(at, 0, centre, port))
    for port, ends in targets.items():
        for end in ends:
            at = graph.add(_make_end(*end, "inputs"))
            graph.wires.append(Wire(centre, port, at, 0))
    return graph


def make_body_graph(
    plant: MultibodyPlant,
    closures: Sequence[tuple[RigidBody, RigidBody]] = (),
) -> Graph:
    """Bodies of a plant and the joints between them, from the world on.

    Args:
        plant: Finalized.
        closures: Pairs of bodies that a constraint holds together, as Drake
            does not tell which those are; drawn dashed.
    """
    graph, at = Graph(f"{plant.get_name()}: bodies and joints"), {}
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    inboard = {int(j.child_body().index()): j.type_name() for j in joints}
    ends = {int(j.parent_body().index()) for j in joints}
    ends |= {int(a.index()) for a, _ in closures}
    for instance in range(plant.num_model_instances()):
        for index in plant.GetBodyIndices(ModelInstanceIndex(instance)):
            body, i = plant.get_body(index), int(index)
            at[i] = graph.add(
                Box(
                    body.name(),
                    _describe_body(plant, body, inboard.get(i)),
                    ("",) if i in inboard else (),
                    ("",) if i in ends else (),
                )
            )
    for joint in joints:
        pair = joint.parent_body(), joint.child_body()
        graph.wires.append(_link(at, *pair, False))
    graph.wires += [_link(at, a, b, True) for a, b in closures]
    return graph


def _link(at, a: RigidBody, b: RigidBody, dashed: bool) -> Wire:
    return Wire(at[int(a.index())], 0, at[int(b.index())], 0, dashed)


def _describe_body(plant, body: RigidBody, joint: str | None) -> str:
    instance = plant.GetModelInstanceName(body.model_instance())
    words = [instance] if instance not in (body.name(), "") else []
    words = [w for w in words if w != "WorldModelInstance"]
    words += [joint.replace("_", " ")] if joint else []
    return ", ".join(words)


def _connections(diagram: Diagram) -> list[tuple[System, int, System, int]]:
    """Source, its port, target, its port, in the order of the systems."""
    order = {system: i for i, system in enumerate(diagram.GetSystems())}
    found = [
        (source, int(output), target, int(port))
        for (target, port), (source, output) in diagram.connection_map().items()
    ]
    return sorted(found, key=lambda c: (order[c[0]], c[1], order[c[2]], c[3]))


def _exported(diagram: Diagram):
    """Inputs and outputs of the whole, as (label, system, port)."""
    entering, leaving = [], []
    for i in range(diagram.num_input_ports()):
        port = diagram.get_input_port(i)
        label = _label(port)
        for system, inner in diagram.GetInputPortLocators(port.get_index()):
            entering.append((label, system, int(inner)))
    for i in range(diagram.num_output_ports()):
        port = diagram.get_output_port(i)
        system, inner = diagram.get_output_port_locator(port.get_index())
        leaving.append((_label(port), system, int(inner)))
    return entering, leaving


def _make_box(system: System, used) -> tuple[Box, dict]:
    """A box with the ports in use, and their rows by (side, port)."""
    labels, rows = {"in": [], "out": []}, {}
    for side, count, label in (
        ("in", system.num_input_ports(), _label_input),
        ("out", system.num_output_ports(), _label_output),
    ):
        for port in range(count):
            if (system, side, port) in used:
                rows[side, port] = len(labels[side])
                labels[side].append(label(system, port))
    total = system.num_input_ports() + system.num_output_ports()
    note = type(system).__name__
    if total > len(rows):
        note += f", idle ports: {total - len(rows)}"
    return Box(system.get_name(), note, *map(tuple, labels.values())), rows


def _make_whole_box(system: System, sources, targets) -> Box:
    inputs = range(system.num_input_ports())
    outputs = range(system.num_output_ports())
    unused = {("in", i) for i in inputs if i not in sources}
    unused |= {("out", i) for i in outputs if i not in targets}
    return Box(
        system.get_name(),
        type(system).__name__,
        tuple(_label_input(system, i) for i in inputs),
        tuple(_label_output(system, i) for i in outputs),
        "subject",
        frozenset(unused),
    )


def _make_end(name: str, label: str | None, side: str) -> Box:
    if label is None:
        return Box(name, kind="port", **{side: ("",)})
    return Box(name, **{side: (label,)})


def _wire(rows, source, output, target, port) -> Wire:
    (a, out), (b, into) = rows[source], rows[target]
    return Wire(a, out["out", output], b, into["in", port])


def _label_input(system: System, port: int) -> str:
    return _label(system.get_input_port(port))


def _label_output(system: System, port: int) -> str:
    return _label(system.get_output_port(port))


def _label(port) -> str:
    if port.get_data_type() == PortDataType.kVectorValued:
        return f"{port.get_name()} [{port.size()}]"
    return port.get_name()
