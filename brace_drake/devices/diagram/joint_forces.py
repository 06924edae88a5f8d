"""What effects at joints push a plant with, step by step.

Dry friction and stiff joints answer within a step to the speed that they
leave: their force is that at the end of the step (backward Euler; Hairer and
Wanner, Solving Ordinary Differential Equations II, section IV.3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from brace_drake.devices.diagram.model import DiagramModel
from brace_drake.effects.stack import Use
from brace_drake.scenario.axis.units import FORCE_N, LENGTH_M
from brace_drake.scenario.diagram import JointSizes

_TRIALS = 40
# Of the change of speed in a step.
_EXACT = 1e-8
# Effects answer in parts of a step of this length, s.
_PART_S = 2e-3


def solve_speed(change: Callable[[float], float], v_free: float) -> float:
    """The speed v = v_free + change(v) in the end of a step.

    By false position in its Illinois variant, which keeps the root between
    where it is, and along the secant before.

    Args:
        change: What a force at a speed changes in the step, falling with it.
        v_free: Speed without the force.
    """
    low, rest_low = v_free, -change(v_free)
    if rest_low == 0.0:
        return v_free
    high = v_free - rest_low
    rest_high = high - v_free - change(high)
    enough, side = _EXACT * abs(rest_low), 0
    for _ in range(_TRIALS):
        if abs(rest_high) <= enough or rest_high == rest_low:
            break
        v = high - rest_high * (high - low) / (rest_high - rest_low)
        rest = v - v_free - change(v)
        is_between = rest * rest_high > 0.0 > rest_low * rest
        if is_between:
            if side == 1:
                rest_low *= 0.5
            side = 1
        else:
            low, rest_low, side = high, rest_high, 0
        high, rest_high = v, rest
    return high


class JointEffects:
    """Effects at one joint, with their memory.

    A force of theirs is that of the machine of reference, see `AxisUnits`.
    """

    def __init__(self, uses: Sequence[Use]):
        """Takes effects with the parameters of reference."""
        self._laws = [effect.laws["drive"] for effect, _ in uses]
        self._parameters = [np.array(values, float) for _, values in uses]
        sizes = [max(1, e.num_states.get("drive", 0)) for e, _ in uses]
        self._memory = [np.zeros(size) for size in sizes]
        self._trial = [np.zeros(size) for size in sizes]
        self._work = np.zeros(5)
        # Force, command, position, speed, viscous friction.
        self._places = [self._work[i : i + 1] for i in range(5)]

    def step(
        self,
        t: float,
        dt: float,
        q: float,
        speeds: tuple[float, float],
        compliance: float,
    ) -> float:
        """The mean force over a step: what moves the joint without the effects
        is the same all along it.

        Where the joint goes on the same way it is that in the middle of the
        step; else the effects answer in parts of it, each at its end.

        Args:
            t, dt: Time at its beginning, and its length, s.
            q: Position at its beginning.
            speeds: At its beginning, and at its end without the effects.
            compliance: Acceleration for each unit of the force.
        """
        v, v_free = speeds
        if v * v_free > 0.0 and abs(v_free - v) < abs(v):
            # The mean speed is half of the two; so is what force changes.
            middle = self._solve(
                t, dt, 0.5 * dt, q, 0.5 * (v + v_free), 0.5 * compliance
            )
            if middle * v > 0.5 * v * v:
                return self._force(
                    t, dt, q + 0.5 * dt * middle, middle, self._memory
                )
        parts = max(1, math.ceil(dt / _PART_S - 1e-9))
        part, rise = dt / parts, (v_free - v) / parts
        whole = 0.0
        for i in range(parts):
            now = t + i * part
            v = self._solve(now, part, part, q, v + rise, compliance)
            q += part * v
            whole += self._force(now, part, q, v, self._memory)
        return whole / parts

    def _solve(
        self,
        t: float,
        dt: float,
        ahead: float,
        q: float,
        v_free: float,
        compliance: float,
    ) -> float:
        """The speed v = v_free + dt c F(q + a v, v), a seconds ahead."""

        def change(v: float) -> float:
            for kept, trial in zip(self._memory, self._trial, strict=True):
                trial[:] = kept
            force = self._force(t, dt, q + ahead * v, v, self._trial)
            return dt * compliance * force

        return solve_speed(change, v_free)

    def _force(self, t, dt, q, v, memory) -> float:
        work = self._work
        work[:] = 0.0
        work[2], work[3] = q, v
        f, u, position, speed, viscous = self._places
        for law, p, x in zip(self._laws, self._parameters, memory, strict=True):
            law(t, dt, u, position, speed, viscous, f, p, x)
        return work[0]


class JointForces:
    """Effects at the joints of one run, with their memory."""

    def __init__(
        self,
        model: DiagramModel,
        sizes: Mapping[str, JointSizes],
        uses: Mapping[str, Sequence[Use]],
    ):
        """Takes a model whose run has been begun.

        Args:
            model: The diagram.
            sizes: Of its joints.
            uses: Effects at each joint, with the parameters of reference.
        """
        self._model = model
        plant = model.plant
        self._none = np.zeros(plant.num_velocities())
        # Of a port that the user has connected, a fixed value takes the place.
        self._fixed = model.force_port.FixValue(model.plant_context, self._none)
        self._joints = []
        for name, own in uses.items():
            length = sizes[name].travel / LENGTH_M
            force = sizes[name].force / FORCE_N
            effects = JointEffects(own)
            self._joints.append((model.joints[name], length, force, effects))

    def apply(self, t: float, dt: float) -> None:
        """Fixes the forces that hold over the step from t on, s."""
        model, plant = self._model, self._model.plant
        context = model.plant_context
        self._set(self._none)
        q = plant.GetPositions(context)
        before = plant.GetVelocities(context)
        v = before + dt * self._free_acceleration(before)
        inverse = np.linalg.inv(plant.CalcMassMatrix(context))
        forces = self._none.copy()
        for joint, length, force, effects in self._joints:
            k = joint.velocity
            tau = force * effects.step(
                t,
                dt,
                q[joint.position] / length,
                (before[k] / length, v[k] / length),
                inverse[k, k] * force / length,
            )
            # What one joint is pushed with moves the others.
            v += dt * tau * inverse[:, k]
            forces[k] += tau
        self._set(forces)

    def _set(self, forces: np.ndarray) -> None:
        self._fixed.GetMutableData().get_mutable_value().SetFromVector(forces)

    def _free_acceleration(self, v: np.ndarray) -> np.ndarray:
        """v' without the effects; over its own step where it has one."""
        plant, context = self._model.plant, self._model.plant_context
        if plant.time_step() == 0.0:
            port = plant.get_generalized_acceleration_output_port()
            return port.Eval(context)
        state = plant.EvalUniquePeriodicDiscreteUpdate(context)
        after = state.value(0)[plant.num_positions() :]
        return (after[: len(v)] - v) / plant.time_step()
