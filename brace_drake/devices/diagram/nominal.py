"""The nominal diagram of a campaign: what it states, and how far it moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydrake.multibody.tree import MultibodyForces

from brace_drake.core.errors import BraceError, ScenarioError
from brace_drake.devices.diagram.factory import MakeDiagram, call_factory
from brace_drake.devices.diagram.imposed import take_imposed_sizes
from brace_drake.devices.diagram.model import (
    DiagramModel,
    check_joints,
    check_ports,
)
from brace_drake.devices.diagram.rollout import simulate_diagram
from brace_drake.devices.diagram.twin import DiagramTwin
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.diagram import (
    BodySizes,
    DiagramScenario,
    JointSizes,
)
from brace_drake.scenario.pad_noise import estimate_white_noise

# Longest step where the campaign states none, s.
_LONGEST_STEP_S = 0.02
# Readings are no better than this part of the range they cover.
_FINEST = 1e-5
# States of a run from which forces at joints are computed.
_STATES = 200
# Part of the noise that a step may be off, and how often it is halved for it.
_ACCURATE, _HALVINGS = 0.2, 6
# Steps of an effect between two samples of an imposed motion.
_STEP_PARTS = 4.0
# A joint that does not move has a size all the same.
_LEAST = 1e-3
# A reading is a position where it is off by this part of its range.
_SAME = 1e-6


def MakeDiagramScenario(
    campaign: Campaign, make: MakeDiagram, name: str = ""
) -> DiagramScenario:
    """The scenario of a diagram that a campaign was recorded on.

    Args:
        campaign: Whose ports and numbers it takes.
        make: Makes the diagram.
        name: Of that function, module:function.

    Raises:
        ScenarioError: The function fails, or ports, joints and columns do not
            fit.
    """
    ports, runs = campaign.ports, campaign.split("fit")
    step = ports.time_step or min(1.0 / campaign.rate_hz, _LONGEST_STEP_S)
    scenario = DiagramScenario(
        diagram=name,
        inputs={k: list(v) for k, v in ports.inputs.items()},
        outputs={k: list(v) for k, v in ports.outputs.items()},
        start=dict(ports.start),
        start_speed=dict(ports.start_speed),
        imposed=dict(ports.imposed),
        forces=dict(ports.forces),
        numbers=dict(ports.numbers),
        fitted={k: list(v) for k, v in ports.fitted.items()},
        deviations=dict(ports.deviations),
        time_step=step,
    )
    model = DiagramModel(call_factory(make, scenario.numbers), step)
    source = str(campaign.path)
    if scenario.is_imposed:
        check_joints(model, source, "imposed", [*scenario.imposed])
        take_imposed_sizes(scenario, runs, model.joints)
    else:
        check_ports(model, source, scenario.inputs, scenario.outputs)
        starts = [*scenario.start, *scenario.start_speed]
        check_joints(model, source, "start", starts)
    for column in (*scenario.commands, *scenario.readings):
        values = [run.channels[column] for run in runs]
        half = 0.5 * float(np.ptp(np.concatenate(values)))
        scenario.ranges[column] = half or 1.0
    for column in scenario.readings:
        sigma = estimate_white_noise([run.channels[column] for run in runs])
        least = _FINEST * scenario.ranges[column]
        scenario.noise[column] = max(sigma, least)
    if scenario.is_imposed:
        scenario.time_step = ports.time_step or step / _STEP_PARTS
        _take_bodies(scenario, model)
        return scenario
    if not ports.time_step:
        _take_step(scenario, make, runs)
    if model.plant is not None:
        _take_sizes(scenario, model, make, runs)
        _take_bodies(scenario, model)
    return scenario


def _take_step(
    scenario: DiagramScenario, make: MakeDiagram, runs: Sequence[Run]
) -> None:
    """The longest step that differs from half of it by less than noise."""
    sigma = np.array([scenario.noise[n] for n in scenario.readings])

    def replay(run: Run) -> np.ndarray:
        twin = DiagramTwin(scenario, make)
        subject = np.array([p.nominal for p in twin.subject])
        try:
            return twin.simulate(twin.motion(run), subject)
        except BraceError:
            return np.full((len(run.time_s), len(sigma)), np.inf)

    for run in runs:
        before = replay(run)
        for _ in range(_HALVINGS):
            scenario.time_step /= 2.0
            after = replay(run)
            with np.errstate(invalid="ignore"):
                off = np.sqrt(np.mean((after - before) ** 2, axis=0))
            if np.all(off <= _ACCURATE * sigma):
                scenario.time_step *= 2.0
                break
            before = after


def _take_sizes(
    scenario: DiagramScenario,
    model: DiagramModel,
    make: MakeDiagram,
    runs: Sequence[Run],
) -> None:
    """Sizes of joints, from replays of the nominal diagram; how far those move
    whose positions were read, from the readings.
    """
    twin, plant = DiagramTwin(scenario, make), model.plant
    states: list[tuple[np.ndarray, np.ndarray]] = []
    forces: list[np.ndarray] = []
    readings: list[np.ndarray] = []
    for run in runs:
        motion = twin.motion(run)
        mine: list[tuple[np.ndarray, np.ndarray]] = []

        def watch(model, mine=mine):
            q = plant.GetPositions(model.plant_context)
            mine.append((q, plant.GetVelocities(model.plant_context)))

        try:
            log = simulate_diagram(
                model, scenario, motion, scenario.time_step, {}, (), watch
            )
        except BraceError as error:
            raise ScenarioError(
                f"{run.file}: the nominal diagram cannot replay it: {error}"
            ) from error
        readings.append(log)
        states += mine
        forces += _forces(model, motion.period, mine)
    q = np.array([state[0] for state in states])
    tau = np.array(forces)
    for name, joint in model.joints.items():
        travel = 0.5 * float(np.ptp(q[:, joint.position]))
        column = _reading_of(q[:, joint.position], np.concatenate(readings))
        if column is not None:
            # A nominal machine may drift far away.
            travel = scenario.ranges[scenario.readings[column]]
        force = float(np.sqrt(np.mean(tau[:, joint.velocity] ** 2)))
        kind = "rotary" if joint.is_rotary else "linear"
        scenario.joints[name] = JointSizes(
            kind, max(travel, _LEAST), max(force, _LEAST)
        )


def _reading_of(position: np.ndarray, readings: np.ndarray) -> int | None:
    """The column (N, C) that reads a position (N,); None where none does."""
    off = np.abs(readings - position[:, None]).max(axis=0)
    same = np.flatnonzero(off <= _SAME * np.ptp(position))
    return int(same[0]) if len(same) and np.ptp(position) > 0.0 else None


def _take_bodies(scenario: DiagramScenario, model: DiagramModel) -> None:
    """Sizes of bodies."""
    for name, body in model.bodies.items():
        M_BBo_B = body.CalcSpatialInertiaInBodyFrame(model.plant_context)
        reach = float(np.linalg.norm(M_BBo_B.get_com()))
        scenario.bodies[name] = BodySizes(M_BBo_B.get_mass(), reach or 0.1)


def _forces(model: DiagramModel, period: float, states) -> list[np.ndarray]:
    """Forces that the motion of a run takes, the larger of those with gravity
    and without, each (v,).
    """
    plant, context = model.plant, model.plant_context
    speeds = np.array([v for _, v in states])
    acceleration = np.gradient(speeds, period, axis=0)
    found = []
    for i in range(0, len(states), max(1, len(states) // _STATES)):
        q, v = states[i]
        plant.SetPositions(context, q)
        plant.SetVelocities(context, v)
        own = MultibodyForces(plant)
        taken = plant.CalcInverseDynamics(context, acceleration[i], own)
        plant.CalcForceElementsContribution(context, own)
        with_weight = plant.CalcInverseDynamics(context, acceleration[i], own)
        found.append(np.maximum(np.abs(taken), np.abs(with_weight)))
    return found
