"""One tick of any of the brace's controllers: leg lengths in, leg forces out.

pose estimator -> virtual poses -> task forces -> legs

For S stages with n = S moving rings. All arrays over task coordinates have 6n
columns, ring by ring from the bottom (see `task_impedance`); the law and what
is remembered are stacks of such rows.
"""

from typing import NamedTuple

import numpy as np
from numba import float64, int64, njit, types

from brace_drake.laws import stages
from brace_drake.laws.compiled import LAW, compiled_law, compiled_maker
from brace_drake.laws.control import mraic, npic, pid, task_impedance, vpic
from brace_drake.laws.control.impedance import filter_force
from brace_drake.laws.control.pose_estimate import (
    NUM_POSE_MEMORY,
    estimate_rings,
)
from brace_drake.laws.hooks import matrix, vector

# Kinds of controllers.
IDC, PIC, MRAIC, NPIC, VPIC, PID = range(6)

# Rows of the law that all kinds share. ESTIMATOR: of each ring position at
# rest (3), period, gains of the low passes of velocity and force.
ESTIMATOR, SELECTED, FED_FORWARD, M_D, C_D, K_D = range(6)
K_P, K_V, MASS, GRAVITY, LIMIT = range(6, 11)
LOWER, UPPER = 11, 14  # anchors as the controller knows them, 3 rows each
NUM_SHARED_LAW = 17

# Rows behind them, and rows of memory behind the filtered force, by kind.
NUM_OWN_LAW = (
    0, 0, mraic.NUM_MRAIC_LAW, npic.NUM_NPIC_LAW, vpic.NUM_VPIC_LAW,
    pid.NUM_PID_LAW,
)  # fmt: skip
NUM_OWN_MEMORY = (
    0, 0, mraic.NUM_MRAIC_MEMORY, npic.NUM_NPIC_MEMORY, vpic.NUM_VPIC_MEMORY,
    pid.NUM_PID_MEMORY,
)  # fmt: skip

# What a tick comes back with.
GOOD, NO_POSE, SINGULAR, BAD_STIFFNESS = range(4)


class Controller(NamedTuple):
    """A controller of n rings: its law, what it remembers, places to work in.

    Attributes:
        kind: IDC, PIC, MRAIC, NPIC, VPIC or PID.
        law: Rows of the kind (rows, 6n).
        geometry: See `take_geometry`.
        rings: Memory of each ring's estimator (n, 20).
        memory: Rows of the kind, the filtered force first (rows, 6n).
        virtual: X_v, X_v', X_v'' (3, 6n).
        impedance: M_d, C_d, K_d in use (3, 6n), 0 where there is none.
        poses: As estimated q_WR, p_WR (n, 7).
        state: As estimated X, X' (2, 6n).
        desired: X_d, X_d', X_d'' (3, 6n).
        F: Task forces (6n,), N and N m.
        work: See `take_work`.
    """

    kind: int
    law: np.ndarray
    geometry: tuple
    rings: np.ndarray
    memory: np.ndarray
    virtual: np.ndarray
    impedance: np.ndarray
    poses: np.ndarray
    state: np.ndarray
    desired: np.ndarray
    F: np.ndarray
    work: tuple


_array3 = float64[:, :, ::1]
CONTROLLER = types.NamedTuple(
    (
        int64, matrix, types.Tuple((matrix, _array3, _array3)), matrix, matrix,
        matrix, matrix, matrix, matrix, matrix, vector,
        types.Tuple(
            (_array3, _array3, vector, _array3, _array3, matrix, vector)
        ),
    ),
    Controller,
)  # fmt: skip
# Memory of the estimators (20n,) and of the kind (rows, 6n), X_v, X_v', X_v''
# (18n,), impedance in use (18n,): what is held from tick to tick.
HELD = types.Tuple((vector, matrix, vector, vector))


@compiled_maker
def take_work(n):
    """Places to work in for a tick of n rings, made in one piece.

    That is poses (n, 7), X and X' (2, 6n), task forces (6n,); and those of
    `estimate_rings` and `send_to_legs`: R (n, 3, 3), lower anchors (n, 6, 3),
    leg lengths (6n,), J and J_L (n, 6, 6), a matrix (6, 6), an estimate (19,).
    """
    work = np.empty(130 * n + 55)
    poses = work[0 : 7 * n].reshape((n, 7))
    state = work[7 * n : 19 * n].reshape((2, 6 * n))
    F = work[19 * n : 25 * n]
    R = work[25 * n : 34 * n].reshape((n, 3, 3))
    p_WB = work[34 * n : 52 * n].reshape((n, 6, 3))
    lengths = work[52 * n : 58 * n]
    J = work[58 * n : 94 * n].reshape((n, 6, 6))
    J_L = work[94 * n : 130 * n].reshape((n, 6, 6))
    scratch = work[130 * n : 130 * n + 36].reshape((6, 6))
    estimate = work[130 * n + 36 :]
    return poses, state, F, (R, p_WB, lengths, J, J_L, scratch, estimate)


@compiled_maker
def take_geometry(law, n):
    """Rows of the law as they are used: estimator, lower, upper anchors.

    That is (n, 6), (n, 6, 3), (n, 6, 3). To look at an array in another shape
    costs as much as some of the laws: a loop over ticks does it once.
    """
    estimator = law[ESTIMATOR].reshape((n, 6))
    lower = law[LOWER : LOWER + 3].reshape((n, 6, 3))
    upper = law[UPPER : UPPER + 3].reshape((n, 6, 3))
    return estimator, lower, upper


def start_held(start, rest, memory):
    """What a controller holds before its first tick, see `HELD`.

    Args:
        start: Task coordinates (6n,), where the rings stand still.
        rest: Of the rings (n, 3), m.
        memory: Of the kind at the start (rows, 6n).
    """
    rings, virtual = (
        np.zeros((len(rest), NUM_POSE_MEMORY)),
        np.zeros(18 * len(rest)),
    )
    poses = np.empty((len(rest), 7))
    stages.place_rings(start, rest, poses)
    rings[:, 0:3], rings[:, 3:7] = poses[:, 4:7], poses[:, 0:4]
    virtual[: len(start)] = start
    return rings.ravel(), memory.copy(), virtual, np.zeros(len(virtual))


@compiled_maker
def make_controller(kind, law, held):
    """The `Controller` of a kind and law that continues from `HELD`."""
    pose, memory, virtual, impedance = held
    nc = law.shape[1]
    poses, state, F, work = take_work(nc // 6)
    return Controller(
        kind,
        law,
        take_geometry(law, nc // 6),
        pose.reshape((nc // 6, NUM_POSE_MEMORY)),
        memory,
        virtual.reshape((3, nc)),
        impedance.reshape((3, nc)),
        poses,
        state,
        np.zeros((3, nc)),
        F,
        work,
    )


@compiled_law
def send_to_legs(controller, command):
    """Leg commands f = J^-T F at the estimated poses, each leg limited.

    Legs of stage i push ring i and pull back ring i - 1, so the stages are
    solved from the top down.

    Returns:
        GOOD, or SINGULAR where a stage is.
    """
    _, lower, upper = controller.geometry
    R, p_WB, lengths, J, J_L, scratch, _ = controller.work
    limit = controller.law[LIMIT]
    stages.calc_kinematics(
        controller.poses, lower, upper, R, p_WB, lengths, J, J_L
    )
    if not stages.solve_leg_forces(J, J_L, controller.F, scratch, command):
        return SINGULAR
    for k in range(command.shape[0]):
        command[k] = min(limit[k], max(-limit[k], command[k]))
    return GOOD


@compiled_law
def advance_virtual(controller, stiffness):
    """Virtual poses and impedance in use of every kind.

    Returns:
        False where a stiffness asked for is not a number.
    """
    kind, law, own = controller.kind, controller.law, controller.memory[1:]
    state, force = controller.state, controller.memory[0]
    desired = controller.desired
    virtual, used = controller.virtual, controller.impedance
    period, selected = law[ESTIMATOR, 3], law[SELECTED]
    wanted, rows = law[M_D : K_D + 1], law[NUM_SHARED_LAW:]
    if kind == PIC:
        task_impedance.advance_pic(
            desired, force, period, selected, law[M_D], law[C_D], law[K_D],
            virtual, used,
        )  # fmt: skip
    elif kind == MRAIC:
        mraic.advance_mraic(
            desired, state, force, period, selected, wanted, rows, own,
            virtual, used,
        )  # fmt: skip
    elif kind == NPIC:
        npic.advance_npic(
            desired, state, force, period, selected, wanted, rows, own,
            virtual, used,
        )  # fmt: skip
    elif kind == VPIC:
        return vpic.advance_vpic(
            desired, state, force, stiffness, period, selected, wanted, rows,
            own, virtual, used,
        )  # fmt: skip
    else:
        task_impedance.advance_idc(desired, virtual, used)
    return True


@compiled_law
def calc_forces(controller, command):
    """Task forces: inverse dynamics (6) to the virtual pose, or PID."""
    law, force = controller.law, controller.memory[0]
    if controller.kind == PID:
        pid.advance_pid(
            controller.desired, controller.state, force, law[ESTIMATOR, 3],
            pid.is_saturated(command, law[LIMIT]), law[NUM_SHARED_LAW:],
            law[GRAVITY], controller.memory[1:], controller.F,
        )  # fmt: skip
    else:
        task_impedance.calc_task_forces(
            controller.state, controller.virtual, force, law[FED_FORWARD],
            law[K_P : K_V + 1], law[MASS], law[GRAVITY], controller.F,
        )  # fmt: skip


# Without a signature: with one, each process that goes decision by decision
# would compile it again, as kept code names what it calls by its signatures.
@njit(**{**LAW, "forceinline": False})
def advance_controller(controller, readings, stiffness, command):
    """One tick.

    Args:
        controller: From `make_controller`, with X_d, X_d', X_d'' in its
            place; what it remembers is updated.
        readings: Leg lengths (6n), m, force of each ring on the torso in W
            (3n), N; more may follow.
        stiffness: Asked for from outside (6n,), or (0,); VPIC alone uses it.
        command: Leg forces (6n,), N: of the last tick, and output.

    Returns:
        GOOD, NO_POSE, SINGULAR or BAD_STIFFNESS.
    """
    law, nc = controller.law, controller.law.shape[1]
    if not estimate_rings(
        readings[0:nc], controller.geometry, controller.rings,
        controller.poses, controller.state, controller.work,
    ):  # fmt: skip
        return NO_POSE
    filter_force(
        readings[nc : nc + nc // 2], law[ESTIMATOR, 5], controller.memory[0]
    )
    if not advance_virtual(controller, stiffness):
        return BAD_STIFFNESS
    calc_forces(controller, command)
    return send_to_legs(controller, command)


@compiled_maker
def advance_brace(kind, law, held, readings, desired, stiffness, command):
    """`advance_controller` for who has no `Controller`, as a LeafSystem.

    Args:
        kind, law: Of the controller.
        held: See `HELD`, updated.
        readings, stiffness, command: As there.
        desired: X_d, X_d', X_d'' (18n,).
    """
    controller = make_controller(kind, law, held)
    controller.desired[:] = desired.reshape((3, law.shape[1]))
    return advance_controller(controller, readings, stiffness, command)
