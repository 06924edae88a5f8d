"""Nominal Drake diagrams of three machines, as users would write them."""

from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.controllers import PidController
from pydrake.systems.framework import DiagramBuilder


def add_rod(plant, name, mass, centre, axis):
    """A slender rod of twice the length of its centre's place."""
    length = 2.0 * sum(c * c for c in centre) ** 0.5
    about_centre = UnitInertia.ThinRod(length, axis)
    inertia = SpatialInertia.MakeFromCentralInertia(
        mass, centre, mass * about_centre
    )
    return plant.AddRigidBody(name, inertia)


def MakeCartPole(numbers):
    """A cart that a force pushes, and a pole that hangs from it."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    cart = plant.AddRigidBody(
        "cart",
        SpatialInertia(
            numbers["cart_mass_kg"], [0, 0, 0], UnitInertia(1, 1, 1)
        ),
    )
    slide = plant.AddJoint(
        PrismaticJoint(
            "slide",
            plant.world_frame(),
            cart.body_frame(),
            [1, 0, 0],
            damping=numbers["slide_damping_N_s_m"],
        )
    )
    pole = add_rod(plant, "pole", 0.2, [0, 0, -0.25], [0, 0, 1])
    plant.AddJoint(
        RevoluteJoint(
            "hinge",
            cart.body_frame(),
            pole.body_frame(),
            [0, -1, 0],
            damping=numbers["hinge_damping_N_m_s_rad"],
        )
    )
    plant.AddJointActuator("motor", slide)
    plant.Finalize()
    builder.ExportInput(plant.get_actuation_input_port(), "force")
    builder.ExportOutput(plant.get_state_output_port(), "state")
    return builder.Build()


def MakeArm(numbers):
    """Two links in the vertical plane, each joint under PD control."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    upper = add_rod(plant, "upper", 1.2, [0, 0, -0.15], [0, 0, 1])
    lower = add_rod(plant, "lower", 0.8, [0, 0, -0.125], [0, 0, 1])
    elbow_frame = plant.AddFrame(
        FixedOffsetFrame("elbow_frame", upper, RigidTransform([0, 0, -0.3]))
    )
    for name, parent, child in (
        ("shoulder", plant.world_frame(), upper),
        ("elbow", elbow_frame, lower),
    ):
        joint = plant.AddJoint(
            RevoluteJoint(
                name,
                parent,
                child.body_frame(),
                [0, -1, 0],
                damping=numbers[f"{name}_damping_N_m_s_rad"],
            )
        )
        plant.AddJointActuator(name, joint)
    plant.Finalize()
    control = builder.AddSystem(PidController([30, 15], [0, 0], [4, 2]))
    builder.Connect(
        plant.get_state_output_port(), control.get_input_port_estimated_state()
    )
    builder.Connect(control.get_output_port(), plant.get_actuation_input_port())
    builder.ExportInput(control.get_input_port_desired_state(), "desired")
    builder.ExportOutput(plant.get_state_output_port(), "state")
    builder.ExportOutput(control.get_output_port(), "torque")
    return builder.Build()


def MakePendulum(numbers):
    """A motor turns an arm about the vertical; a pendulum hangs at its end."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(0.0))
    arm = add_rod(plant, "arm", 0.3, [0.1, 0, 0], [1, 0, 0])
    pendulum = add_rod(plant, "pendulum", 0.1, [0, 0, -0.12], [0, 0, 1])
    end = plant.AddFrame(
        FixedOffsetFrame("end", arm, RigidTransform([0.2, 0, 0]))
    )
    turn = plant.AddJoint(
        RevoluteJoint(
            "turn",
            plant.world_frame(),
            arm.body_frame(),
            [0, 0, 1],
            damping=numbers["turn_damping_N_m_s_rad"],
        )
    )
    plant.AddJoint(
        RevoluteJoint(
            "swing",
            end,
            pendulum.body_frame(),
            [1, 0, 0],
            damping=numbers["swing_damping_N_m_s_rad"],
        )
    )
    plant.AddJointActuator("motor", turn)
    plant.Finalize()
    builder.ExportInput(plant.get_actuation_input_port(), "torque")
    builder.ExportOutput(plant.get_state_output_port(), "state")
    return builder.Build()
