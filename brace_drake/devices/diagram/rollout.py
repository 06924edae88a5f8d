"""One run of a diagram on recorded commands, with effects at its places."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.diagram.joint_forces import JointForces
from brace_drake.devices.diagram.model import DiagramModel
from brace_drake.effects.series import held_commands, pass_series
from brace_drake.effects.signal.ways import COMMAND, READING
from brace_drake.effects.stack import Use
from brace_drake.scenario.diagram import DiagramScenario
from brace_drake.scenario.diagram.cards import JOINT

_LARGEST = 1e9


@dataclass(frozen=True)
class Commanded:
    """What a run is commanded, and from where it starts.

    Attributes:
        period: Between two samples, s.
        commands: Columns of the inputs (N, I).
        start: Position and speed of joints.
    """

    period: float
    commands: np.ndarray
    start: Mapping[str, tuple[float, float]]


def uses_by_place(
    scenario: DiagramScenario, uses: Sequence[Use]
) -> dict[str, dict[str, list[Use]]]:
    """Effects with the parameters of reference, by place and target."""
    cards = scenario.placed_cards()
    found: dict[str, dict[str, list[Use]]] = {
        COMMAND: {},
        READING: {},
        JOINT: {},
    }
    for effect, values in uses:
        placed = cards[effect.key]
        if placed.place in found:
            own = found[placed.place].setdefault(placed.target, [])
            own.append((effect, placed.of_reference(values)))
    return found


def simulate_diagram(
    model: DiagramModel,
    scenario: DiagramScenario,
    motion: Commanded,
    time_step: float,
    payloads: Mapping[str, tuple[float, float]],
    uses: Sequence[Use],
    watch: Callable[[DiagramModel], None] | None = None,
) -> np.ndarray:
    """Simulates one run, up to what its readings suffer: see `read_log`.

    Args:
        model: The diagram, with the numbers of a machine.
        scenario: Its ports and sizes.
        motion: The run.
        time_step: Longest step, s.
        payloads: Mass, kg, and distance, m, on bodies.
        uses: Effects with their parameters.
        watch: Called with the model at every sample.

    Returns:
        Readings, in the order of `scenario.readings` (N, C).

    Raises:
        BraceError: The run broke down (the message says when).
    """
    places = uses_by_place(scenario, uses)
    steps = max(1, math.ceil(motion.period / time_step - 1e-9))
    columns = list(scenario.commands)
    held = held_commands(
        motion.commands,
        motion.period,
        steps,
        [scenario.ranges.get(n, 1.0) for n in columns],
        {columns.index(n): own for n, own in places[COMMAND].items()},
    )
    return _run(
        model, scenario, motion, held, steps, payloads, places[JOINT], watch
    )


def read_log(
    scenario: DiagramScenario,
    motion: Commanded,
    log: np.ndarray,
    uses: Sequence[Use],
) -> np.ndarray:
    """What effects on readings make of a run's log (N, C)."""
    places = uses_by_place(scenario, uses)[READING]
    names, out = scenario.readings, np.array(log)
    for name, own in places.items():
        c = names.index(name)
        size = scenario.ranges.get(name, 1.0)
        out[:, c] = pass_series(log[:, c], motion.period, size, own)
    return out


def _run(
    model: DiagramModel,
    scenario: DiagramScenario,
    motion: Commanded,
    held: np.ndarray,
    steps: int,
    payloads: Mapping[str, tuple[float, float]],
    at_joints: Mapping[str, Sequence[Use]],
    watch: Callable[[DiagramModel], None] | None,
) -> np.ndarray:
    """Readings without their own effects (N, C)."""
    diagram, samples = model.diagram, len(motion.commands)
    model.reset(payloads)
    for name, (position, speed) in motion.start.items():
        model.start_joint(name, position, speed)
    fixed, end = [], 0
    for name, columns in scenario.inputs.items():
        begin, end = end, end + len(columns)
        port = diagram.GetInputPort(name)
        value = port.FixValue(model.context, held[0, begin:end])
        fixed.append((value, slice(begin, end)))
    ports = [diagram.GetOutputPort(name) for name in scenario.outputs]
    forces = None
    if at_joints:
        forces = JointForces(model, scenario.joints, at_joints)
    elif model.plant is not None:
        model.force_port.FixValue(
            model.plant_context, np.zeros(model.plant.num_velocities())
        )
    log = np.zeros((samples, len(scenario.readings)))
    dt = motion.period / steps

    def command(step: int) -> None:
        if step == 0 or (held[step] != held[step - 1]).any():
            for value, part in fixed:
                vector = value.GetMutableData().get_mutable_value()
                vector.SetFromVector(held[step, part])

    i = 0
    try:
        model.initialize()
        for i in range(samples):
            # What is read answers to what is commanded at the same time.
            command(i * steps)
            row = [port.Eval(model.context) for port in ports]
            log[i] = np.concatenate(row)
            if watch is not None:
                watch(model)
            if not np.abs(log[i]).max() < _LARGEST:
                raise RuntimeError("it grows without bound")
            if i == samples - 1:
                break
            for step in range(i * steps, (i + 1) * steps):
                command(step)
                if forces is not None:
                    forces.apply(step * dt, dt)
                model.advance((step + 1) * dt)
    except RuntimeError as error:
        time = i * motion.period
        raise BraceError(
            f"the simulated run broke down at {time:.3f} s: {error}"
        ) from error
    return log
