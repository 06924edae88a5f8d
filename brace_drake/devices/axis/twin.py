"""The axis' twin as fits and diagnoses see it."""

from __future__ import annotations

import copy

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.devices.axis.motion import AxisMotion, MakeAxisMotion
from brace_drake.devices.pad_bench.twin import (
    draw_force_noise,
    steps_per_sample,
)
from brace_drake.devices.subject import SubjectParameter
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.stack import stack_effects
from brace_drake.laws.alone.axis_rollout import GAINS, WORK, rollout_axis
from brace_drake.laws.plug_in import idle
from brace_drake.recording.columns import AXIS
from brace_drake.recording.recording import Run
from brace_drake.recording.ways import axis_columns
from brace_drake.scenario.axis import (
    AxisNumbers,
    AxisScenario,
    AxisUnits,
    input_unit,
    pack_axis,
)

# Plug points that an axis has.
POINTS = ("drive", "sensing")
# Longer steps that suffice for differences between points.
_COARSE = 2.0
# A number of the machine is at most so many times what would make all of the
# force.
_MOST = 10.0


class AxisTwin(ReplayTwin):
    """Moves one axis along recorded positions."""

    device = AXIS
    has_loop = False

    def __init__(self, scenario: AxisScenario, time_step: float | None = None):
        self.position, force = axis_columns(scenario.kind, scenario.command)
        self.channels = (force,)
        self.inputs = tuple(scenario.gains)
        self.units = scenario.units
        super().__init__(scenario, pack_axis(scenario), time_step)
        self.subject = axis_subject(scenario, self.units)

    def coarse(self) -> AxisTwin:
        """The same twin with longer steps of the effects' states."""
        return AxisTwin(self.scenario, self.time_step * _COARSE)

    def scenario_of(self, subject: np.ndarray) -> AxisScenario:
        """The scenario with a machine's fitted numbers, a copy."""
        out = copy.deepcopy(self.scenario)
        for name, value in zip(self.scenario.fitted, subject, strict=True):
            if name in out.gains:
                out.gains[name] = float(value)
            else:
                setattr(out, name, float(value))
        return out

    def with_subject(self, values: np.ndarray) -> AxisNumbers:
        """The numbers of a machine, values in the order of `subject`."""
        law = self.numbers.law.copy()
        for name, value in zip(self.scenario.fitted, values, strict=True):
            law[_place(self.scenario, name)] = value
        return self.numbers.with_changes(law=law)

    def motion(self, run: Run) -> AxisMotion:
        """The run's path and extra inputs."""
        sigma = self.numbers.position_noise[0]
        return MakeAxisMotion(run, self.position, self.inputs, sigma)

    def measured(self, run: Run) -> np.ndarray:
        """Recorded forces, as far as the motion is known (N, 1)."""
        return self.trust(self.motion(run)) * self.written(run)

    def written(self, run: Run) -> np.ndarray:
        return super().measured(run)

    def trust(self, motion: AxisMotion) -> np.ndarray:
        """See `AxisMotion.trust` (N, 1)."""
        mass, noise = self.scenario.most_mass, self.scenario.force_doubt
        return motion.trust(mass, noise)[:, None]

    def _replay(self, numbers, motion, subject, uses, generator):
        """The noise of position goes through the motion's smoothing."""
        noise, force_noise = None, 0.0
        if generator is not None:
            noise = generator.standard_normal(len(motion.time))
            noise = noise * numbers.position_noise[0]
            force_noise = draw_force_noise(
                numbers.force_noise, motion.time, generator
            )
        length, force = self.units.length, self.units.force
        sizes = [self.scenario.input_scales[n] for n in self.inputs]
        readings = simulate_axis(
            self._law_of_reference(numbers.law),
            motion.time,
            motion.path(noise) / length,
            motion.inputs / np.array(sizes),
            self.time_step,
            self.scenario.of_reference(uses),
        )
        return self.trust(motion) * (force * readings + force_noise)[:, None]

    def _law_of_reference(self, law: np.ndarray) -> np.ndarray:
        """The law of the machine of reference, see `units`."""
        inertia = self.units.force / self.units.length
        out = law / self.units.force
        out[:3] = law[:3] / inertia
        out[GAINS:] *= [self.scenario.input_scales[n] for n in self.inputs]
        return out


def simulate_axis(
    law: np.ndarray,
    time: np.ndarray,
    path: np.ndarray,
    inputs: np.ndarray,
    time_step: float,
    uses=(),
) -> np.ndarray:
    """Simulates one run with the compiled rollout.

    Args:
        law: Mass, viscous, stiffness, offset, gains (4 + J,).
        time: Sample times from 0 (N,), s.
        path: Position, rate and acceleration at the samples (N, 3).
        inputs: Extra inputs (N, J).
        time_step: Longest step of the effects' states, s.
        uses: Effects with their parameters.

    Returns:
        Force readings (N,).

    Raises:
        BraceError: The run broke down (the message says when).
    """
    plug_ins = stack_effects(uses)
    plugs = [plug_ins.get(point) or idle(point) for point in POINTS]
    work = np.zeros(len(time) + WORK + inputs.shape[1])
    broke_at = rollout_axis(
        steps_per_sample(time, time_step),
        time,
        np.ascontiguousarray(path),
        np.ascontiguousarray(inputs),
        law,
        *(p.laws for p in plugs),
        plugs[0].parameters,
        *(p.fresh_memory() for p in plugs),
        np.array([p.active for p in plugs]),
        work,
    )
    if broke_at >= 0:
        raise BraceError(
            f"the simulated run broke down at {time[broke_at]:.3f} s"
        )
    return work[: len(time)].copy()


def _place(scenario: AxisScenario, name: str) -> int:
    """Where a number of the machine stands in the law."""
    names = ["mass", "viscous", "stiffness", "offset", *scenario.gains]
    return names.index(name)


# Name and unit of each number of the machine.
_NAMED = {
    "mass": ("mass_kg", "kg"),
    "viscous": ("viscous_N_s_m", "N s/m"),
    "stiffness": ("stiffness_N_m", "N/m"),
    "offset": ("offset_N", "N"),
}


def _named(name: str, units: AxisUnits) -> tuple[str, str]:
    """Name and unit of a number of the machine, as its axis has them."""
    if name in _NAMED:
        known, unit = _NAMED[name]
        return units.name(known, unit), units.unit(unit)
    quantity, of_input = input_unit(name)
    force = units.unit("N")
    whole = f"per_{quantity}_{force}_{of_input}"
    return whole.replace(" ", "_"), f"{force}/({of_input})"


def axis_subject(
    scenario: AxisScenario, units: AxisUnits
) -> tuple[SubjectParameter, ...]:
    """Numbers of the machine that are fitted, with nominal values and limits.

    Each is counted in what makes all of the force by itself.
    """
    force = scenario.force_scale
    sizes = {
        "mass": force / scenario.acceleration_scale,
        "viscous": force / scenario.speed_scale,
        "stiffness": force / scenario.length_scale,
        "offset": force,
    }
    law, found = pack_axis(scenario).law, []
    for name in scenario.fitted:
        value = float(law[_place(scenario, name)])
        named, unit = _named(name, units)
        size = sizes.get(name) or force / scenario.input_scales[name]
        most = _MOST * max(size, abs(value))
        either = name == "offset" or name in scenario.gains
        found.append(
            SubjectParameter(
                named,
                unit,
                value,
                -most if either else 0.0,
                most,
                size,
            )
        )
    if not found:
        raise BraceError("an axis of which nothing is fitted")
    return tuple(found)
