"""A user's diagram, ready to be run: its ports, its plant, its context."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    ModelInstanceIndex,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import (
    Diagram,
    InputPort,
    OutputPort,
    PortDataType,
)

from brace_drake.core.errors import ScenarioError, suggest

# A body of less mass is a frame.
_LEAST_KG = 1e-9


@dataclass(frozen=True)
class PlantJoint:
    """A joint of one degree of freedom.

    Attributes:
        name: Its own; with its model's where that is not unique.
        is_rotary: Whether it turns.
        position, velocity: Its places in q and v.
    """

    name: str
    is_rotary: bool
    position: int
    velocity: int


class DiagramModel:
    """One diagram with one context, which runs begin anew in.

    Attributes:
        diagram: The user's.
        plant: Its `MultibodyPlant`; None without one.
        joints, bodies: Of the plant by name: joints of one degree of freedom,
            and bodies with mass that move.
    """

    def __init__(self, diagram: Diagram, time_step: float):
        """Takes a diagram and the longest step of its integration, s."""
        self.diagram = diagram
        plants = [s for s in _leaves(diagram) if isinstance(s, MultibodyPlant)]
        self.plant = plants[0] if len(plants) == 1 else None
        self.joints = _joints(self.plant) if self.plant else {}
        self.bodies = _bodies(self.plant) if self.plant else {}
        self._simulator = Simulator(diagram)
        integrator = self._simulator.get_mutable_integrator()
        integrator.set_maximum_step_size(time_step)
        integrator.set_fixed_step_mode(True)
        self.context = self._simulator.get_mutable_context()
        self._begin = self.context.Clone()
        self.plant_context = (
            self.plant.GetMyMutableContextFromRoot(self.context)
            if self.plant
            else None
        )
        self._inertias = {
            name: body.CalcSpatialInertiaInBodyFrame(self.plant_context)
            for name, body in self.bodies.items()
        }

    @property
    def force_port(self) -> InputPort:
        """Where effects at joints enter the plant."""
        return self.plant.get_applied_generalized_force_input_port()

    def reset(self, payloads: Mapping[str, tuple[float, float]]) -> None:
        """Back to the start, with masses, kg, at distances, m, on bodies."""
        self.context.SetTimeStateAndParametersFrom(self._begin)
        for name, (mass, distance) in payloads.items():
            M_BBo_B = self._inertias[name]
            p_BoBcm = M_BBo_B.get_com()
            length = np.linalg.norm(p_BoBcm)
            # A centre in the body's frame has no direction of its own.
            way = p_BoBcm / length if length > 1e-9 else np.eye(3)[2]
            self.bodies[name].SetSpatialInertiaInBodyFrame(
                self.plant_context, _with_point(M_BBo_B, mass, distance * way)
            )

    def start_joint(self, name: str, position: float, speed: float) -> None:
        """Puts a joint at a place, with a speed."""
        joint = self.joints[name]
        plant, context = self.plant, self.plant_context
        q, v = plant.GetPositions(context), plant.GetVelocities(context)
        q[joint.position], v[joint.velocity] = position, speed
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)

    def initialize(self) -> None:
        """Before the first step, once inputs and state are set."""
        self._simulator.Initialize()

    def advance(self, time: float) -> None:
        """To a time, s."""
        self._simulator.AdvanceTo(time)


def check_ports(
    model: DiagramModel, source: str, inputs: Mapping, outputs: Mapping
) -> None:
    """Checks that ports are there, are of vectors, and as long as said.

    Args:
        model: Of the user's diagram.
        source: Named in the error.
        inputs, outputs: Columns of each port.

    Raises:
        ScenarioError: One line: port, and what there is.
    """
    diagram = model.diagram
    ins = [diagram.get_input_port(i) for i in range(diagram.num_input_ports())]
    outs = [
        diagram.get_output_port(i) for i in range(diagram.num_output_ports())
    ]
    for kind, wanted, ports in (
        ("inputs", inputs, ins),
        ("outputs", outputs, outs),
    ):
        there = {port.get_name(): port for port in ports}
        for name, columns in wanted.items():
            _check_port(source, kind, name, columns, there)
    open_ = {p.get_name() for p in ins} - set(inputs)
    if open_:
        names = ", ".join(sorted(open_))
        raise ScenarioError(
            f"{source}: diagram.inputs says nothing of the input port {names}"
        )


def _check_port(
    source: str,
    kind: str,
    name: str,
    columns,
    there: Mapping[str, InputPort | OutputPort],
) -> None:
    at = f"{source}: diagram.{kind}: the diagram"
    if name not in there:
        names = ", ".join(there) or "none"
        hint = suggest(name, there)
        raise ScenarioError(
            f"{at} has no port {name!r}{hint or f'; there are {names}'}"
        )
    port = there[name]
    if port.get_data_type() != PortDataType.kVectorValued:
        raise ScenarioError(f"{at}'s port {name!r} is no vector")
    if port.size() != len(columns):
        raise ScenarioError(
            f"{at}'s port {name!r} has {port.size()} elements, and"
            f" {len(columns)} columns"
        )


def check_joints(model: DiagramModel, source: str, key: str, names) -> None:
    """Checks that joints are there.

    Args:
        model: Of the user's diagram.
        source, key: Named in the error.
        names: Of the joints.

    Raises:
        ScenarioError: One line: joint, and what there is.
    """
    for name in names:
        if name not in model.joints:
            hint = suggest(name, model.joints)
            there = ", ".join(model.joints) or "none"
            raise ScenarioError(
                f"{source}: diagram.{key}: the plant has no joint {name!r} of"
                f" one degree of freedom{hint or f'; there are {there}'}"
            )


def _leaves(diagram: Diagram):
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from _leaves(system)
        else:
            yield system


def _unique(plant: MultibodyPlant, parts) -> dict:
    """Parts by name, with that of their model where several share it."""
    names = [part.name() for part in parts]
    return {
        (
            part.name()
            if names.count(part.name()) == 1
            else f"{plant.GetModelInstanceName(part.model_instance())}."
            f"{part.name()}"
        ): part
        for part in parts
    }


def _joints(plant: MultibodyPlant) -> dict[str, PlantJoint]:
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    able = [j for j in joints if isinstance(j, RevoluteJoint | PrismaticJoint)]
    return {
        name: PlantJoint(
            name,
            isinstance(joint, RevoluteJoint),
            joint.position_start(),
            joint.velocity_start(),
        )
        for name, joint in _unique(plant, able).items()
    }


def _bodies(plant: MultibodyPlant) -> dict:
    fixed = {b.index() for b in plant.GetBodiesWeldedTo(plant.world_body())}
    bodies = [
        plant.get_body(i)
        for instance in range(plant.num_model_instances())
        for i in plant.GetBodyIndices(ModelInstanceIndex(instance))
    ]
    able = [
        b
        for b in bodies
        if b.index() not in fixed and b.default_mass() > _LEAST_KG
    ]
    return _unique(plant, able)


def _with_point(
    M_BBo_B: SpatialInertia, mass: float, p_BoQ_B: np.ndarray
) -> SpatialInertia:
    """An inertia with a point mass more, which may be below 0."""
    whole = M_BBo_B.get_mass() + mass
    p_BoBcm = M_BBo_B.get_mass() * M_BBo_B.get_com() + mass * p_BoQ_B
    square = float(p_BoQ_B @ p_BoQ_B)
    I_BBo = M_BBo_B.CalcRotationalInertia().CopyToFullMatrix3()
    I_BBo = I_BBo + mass * (square * np.eye(3) - np.outer(p_BoQ_B, p_BoQ_B))
    G = I_BBo / whole
    return SpatialInertia(
        whole,
        p_BoBcm / whole,
        UnitInertia(G[0, 0], G[1, 1], G[2, 2], G[0, 1], G[0, 2], G[1, 2]),
        skip_validity_check=True,
    )
