"""The bench's bodies as a Drake plant."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.systems.framework import DiagramBuilder

from brace_drake.resources import sdf_path
from brace_drake.scenario.bench import BenchScenario


def _model_with_inertia(name: str, mass: float, moments: np.ndarray) -> str:
    """The SDF text of `sdf/{name}.sdf` with a scenario's mass and moments."""
    root = ElementTree.parse(sdf_path(f"{name}.sdf")).getroot()
    values = {"mass": mass}
    values |= dict(zip(("ixx", "iyy", "izz"), moments, strict=True))
    for tag, value in values.items():
        root.find(f".//inertial//{tag}").text = repr(float(value))
    return ElementTree.tostring(root, encoding="unicode")


def AddBenchPlant(
    builder: DiagramBuilder, scenario: BenchScenario
) -> MultibodyPlant:
    """Adds the finalized plant of ring and, where present, torso.

    Both float freely (the paper's six-degree-of-freedom joint); q holds the
    ring first, then the torso. Gravity acts on the ring alone: the pelvis
    carries the torso. Legs, posture and linear contact are forces that other
    systems apply.
    """
    plant = builder.AddNamedSystem(
        "plant", MultibodyPlant(time_step=scenario.time_step)
    )
    AddBenchBodies(plant, scenario)
    # Sampled ports would make the plant's step an unrestricted update, whose
    # copies of all state cost more than the step.
    plant.SetUseSampledOutputPorts(False)
    if not plant_resolves_contact(scenario):
        # Nothing is left to the contact solver: take the cheapest.
        plant.set_discrete_contact_approximation(
            DiscreteContactApproximation.kTamsi
        )
    plant.Finalize()
    return plant


def plant_resolves_contact(scenario: BenchScenario) -> bool:
    """Whether pads and torso meet in the plant, not in a computed force."""
    return scenario.torso.present and scenario.contact.model == "hydroelastic"


def AddBenchBodies(plant: MultibodyPlant, scenario: BenchScenario) -> None:
    """Adds ring and torso at their rest poses to a plant not yet final."""
    plant.mutable_gravity_field().set_gravity_vector(
        [0.0, 0.0, -scenario.gravity]
    )
    X_WRest = RigidTransform([0.0, 0.0, scenario.stage.upper_height])
    bodies = {"ring2": scenario.ring}
    if scenario.torso.present:
        bodies["torso"] = scenario.torso
    for name, config in bodies.items():
        text = _model_with_inertia(name, config.mass, config.inertia)
        (instance,) = Parser(plant).AddModelsFromString(text, "sdf")
        body = plant.GetBodyByName(name, instance)
        plant.SetDefaultFloatingBaseBodyPose(body, X_WRest)
        if name == "torso":
            plant.set_gravity_enabled(instance, False)
