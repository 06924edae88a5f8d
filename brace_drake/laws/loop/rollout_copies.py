"""Runs of several copies of a brace at once, in compiled code.

The same step and the same laws as in `laws.loop.rollout`, with lanes in place
of floats, see `laws.lanes`. Copies differ in their numbers, effects, motion and
noise; whether there is a torso is the same.
"""

from numba import float64, int64, types

from brace_drake.laws.compiled import (
    MAKER,
    compiled_law,
    compiled_when_called,
)
from brace_drake.laws.control import task_impedance
from brace_drake.laws.control.brace_control import (
    C_D,
    CONTROLLER,
    ESTIMATOR,
    FED_FORWARD,
    GOOD,
    GRAVITY,
    K_D,
    K_P,
    K_V,
    M_D,
    MASS,
    SELECTED,
    send_to_legs,
)
from brace_drake.laws.control.impedance import filter_force
from brace_drake.laws.control.pose_estimate import estimate_rings
from brace_drake.laws.hooks import EFFECTS
from brace_drake.laws.lanes.arrays import lanes_of, stacked_kind
from brace_drake.laws.loop.brace import BRACE, is_near
from brace_drake.laws.loop.rollout import place_desired, write_row
from brace_drake.laws.loop.ticks import go_to_tick
from brace_drake.laws.numbers import NUMBERS

_array3, _array4 = float64[:, :, ::1], float64[:, :, :, ::1]


@compiled_law
def estimate_copies(controller, readings):
    """What the controllers of all copies know of their rings at a tick.

    Args:
        controller, readings: As `brace_control.advance_controller` takes
            them, of lanes.

    Returns:
        Whether a pose was found in all copies.
    """
    law, nc = controller.law, controller.law.shape[1]
    if not estimate_rings(
        readings[0:nc], controller.geometry, controller.rings,
        controller.poses, controller.state, controller.work,
    ):  # fmt: skip
        return False
    force = controller.memory[0]
    filter_force(readings[nc : nc + nc // 2], law[ESTIMATOR, 5], force)
    return True


@compiled_law
def command_copies(controller, command):
    """Leg commands of all copies from their virtual poses; GOOD or SINGULAR."""
    law, force = controller.law, controller.memory[0]
    task_impedance.calc_task_forces(
        controller.state, controller.virtual, force, law[FED_FORWARD],
        law[K_P : K_V + 1], law[MASS], law[GRAVITY], controller.F,
    )  # fmt: skip
    return send_to_legs(controller, command)


@compiled_law
def advance_copies(controller, readings, command):
    """One tick of the controllers of all copies, under PIC.

    Args:
        controller, readings, command: As `brace_control.advance_controller`
            takes them, of lanes.

    Returns:
        Whether it went well in all copies.
    """
    if not estimate_copies(controller, readings):
        return False
    law = controller.law
    task_impedance.advance_pic(
        controller.desired, controller.memory[0], law[ESTIMATOR, 3],
        law[SELECTED], law[M_D], law[C_D], law[K_D], controller.virtual,
        controller.impedance,
    )  # fmt: skip
    return command_copies(controller, command) == GOOD


@compiled_when_called(
    (
        float64, int64, stacked_kind(NUMBERS), EFFECTS,
        stacked_kind(BRACE), stacked_kind(CONTROLLER),
        types.Tuple((_array4, int64[::1], _array3, int64)), _array3,
    ),
    nogil=True,
    **MAKER,
)  # fmt: skip
def rollout_copies(dt, steps, numbers, effects, brace, controller, plan, log):
    """Simulates a run of each copy and writes their logs.

    Args:
        dt, steps: Step of the plant, s; steps in a control period.
        numbers, brace, controller: Of the copies, see `lanes.stack_copies`;
            brace and controller are updated.
        effects: Of the copies; states are updated.
        plan: desired, columns, noise and ticks_per_sample of `RunPlan`, the
            desired motions (ticks, 3, m, COUNT) and noise of the copies.
        log: Output (samples, 15n + 3 + m, COUNT), as there.

    Returns:
        Whether no copy broke down. Where one did, none is of use.
    """
    numbers, brace = lanes_of(numbers), lanes_of(brace)
    controller, log = lanes_of(controller), lanes_of(log)
    desired, columns, noise, every = plan
    desired, noise = lanes_of(desired), lanes_of(noise)
    for tick in range(desired.shape[0]):
        own = noise[tick] if noise.shape[0] > 0 else brace.u[0:0]
        go_to_tick(tick, dt, steps, numbers, effects, brace, own)
        place_desired(desired[tick], columns, controller.desired)
        if not advance_copies(controller, brace.readings, brace.u):
            return False
        if not is_near(numbers, brace):
            return False
        if tick % every == 0:
            row = log[tick // every]
            write_row(brace, controller.virtual, columns, row)
    return True
