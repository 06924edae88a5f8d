"""The laws of a plant step and of a tick, each in one call from a LeafSystem.

A call from Python into compiled code pays for each array that it hands over,
and small arrays made inside cost as much as what they hold: so a system hands
over few, with the place to work in among them.
"""

import numpy as np

from brace_drake.laws import stages
from brace_drake.laws.compiled import compiled_law, compiled_maker
from brace_drake.laws.control import brace_control
from brace_drake.laws.control.pose_estimate import NUM_POSE_MEMORY
from brace_drake.laws.loop import blocks
from brace_drake.laws.rotation import quaternion_to_matrix


def num_tick_law(num_stages: int) -> int:
    """Size of the law of a tick of PIC with its instruments.

    That is resolution (2), noise sigma (9 S + 3), then the shared rows of
    `brace_control` one after another (102 S).
    """
    return 5 + 9 * num_stages + 6 * brace_control.NUM_SHARED_LAW * num_stages


def tick_sizes(num_stages: int) -> tuple[int, ...]:
    """Sizes of what a tick of PIC with its instruments leaves, in order.

    Leg command (6 S), readings: lengths (6 S), forces (3 S), marker (3);
    X_v, X_v', X_v'' (18 S), impedance in use (18 S); then memory: filtered
    force (6 S), pose estimators (20 S).
    """
    n = num_stages
    return 6 * n, 6 * n, 3 * n, 3, 18 * n, 18 * n, 6 * n, 20 * n


def num_law(num_stages: int) -> int:
    """Size of the law of a brace's forces.

    That is To at rest (3), viscous (6 S), lower anchors (18 S), upper anchors
    (18 S), contact of each ring (6 S), posture (12). A contact whose stiffness
    and damping are 0 is none.
    """
    return 15 + 48 * num_stages


def num_forces(num_stages: int, with_work: bool = False) -> int:
    """Size of a brace's forces and signals.

    That is F on the rings (6 S) and on the torso (6), torque first; leg
    lengths (6 S), force of each ring on the torso (3 S), displacement and
    rotation vector of the torso (6); then a place to work in: J and J_L (72 S),
    rates and leg forces (12 S), rotations (9 S) and lower anchors (18 S) of
    rings and stages, pads (34 S), states of a ring and the torso (26), rotation
    of the torso (9).
    """
    work = 145 * num_stages + 35 if with_work else 0
    return 15 * num_stages + 12 + work


@compiled_maker
def add_absent_torso(state):
    """The state (13,) of the ring alone as that of both bodies (26,)."""
    bodies = np.zeros(26)
    bodies[0:7] = state[0:7]
    bodies[14:20] = state[7:13]
    return bodies


@compiled_maker
def _take_work(out, n):
    """The places to work in behind a brace's forces, see `num_forces`."""
    at = 15 * n + 12
    J = out[at : at + 36 * n].reshape((n, 6, 6))
    at += 36 * n
    J_L = out[at : at + 36 * n].reshape((n, 6, 6))
    at += 36 * n
    rates, f = out[at : at + 6 * n], out[at + 6 * n : at + 12 * n]
    at += 12 * n
    R = out[at : at + 9 * n].reshape((n, 3, 3))
    at += 9 * n
    p_WB = out[at : at + 18 * n].reshape((n, 6, 3))
    at += 18 * n
    pads = out[at : at + 34 * n].reshape((n, 2, 17))
    at += 34 * n
    pair, R_WT = out[at : at + 26], out[at + 26 : at + 35].reshape((3, 3))
    return J, J_L, rates, f, R, p_WB, pads, pair, R_WT


@compiled_law
def _copy_state(pose, V, to_pose, to_V):
    for c in range(7):
        to_pose[c] = pose[c]
    for c in range(6):
        to_V[c] = V[c]


@compiled_law
def _add_legs(J, J_L, V, u, viscous, rates, f, F):
    stages.calc_rates(J, J_L, V, rates)
    blocks.calc_leg_forces(u, viscous, rates, f)
    stages.add_wrenches(J, J_L, f, F)


@compiled_maker
def calc_brace(inputs, n, with_pads, with_legs, out):
    """All nominal forces of a brace, and what its instruments see.

    Args:
        inputs: q, p of the rings from the lowest up and, where present, of the
            torso, then [w; v] of each (13 n) or (13 n + 13); held leg commands
            (6 n), N; law, see `num_law`.
        n: Number of stages.
        with_pads: Whether pads press on the torso.
        with_legs: Whether the legs' forces are among those on the rings; else
            the legs are bodies that the plant drives.
        out: See `num_forces`, overwritten, with the place to work in behind
            it; the torso's part is left alone where it is absent.
    """
    size = inputs.shape[0] - 15 - 54 * n
    with_torso = size == 13 * n + 13
    num_bodies = n + 1 if with_torso else n
    poses = inputs[0 : 7 * num_bodies].reshape((num_bodies, 7))
    V = inputs[7 * num_bodies : size].reshape((num_bodies, 6))
    u, law = inputs[size : size + 6 * n], inputs[size + 6 * n :]
    at = 3 + 6 * n
    lower = law[at : at + 18 * n].reshape((n, 6, 3))
    upper = law[at + 18 * n : at + 36 * n].reshape((n, 6, 3))
    contact = law[at + 36 * n : at + 42 * n].reshape((n, 6))
    J, J_L, rates, f, R, p_WB, pads, pair, R_WT = _take_work(out, n)
    F, F_T_W = out[0 : 6 * n].reshape((n, 6)), out[6 * n : 6 * n + 6]
    f_T_W = out[12 * n + 6 : 15 * n + 6].reshape((n, 3))
    for c in range(6 * n + 6):
        out[c] = 0.0
    for c in range(12 * n + 6, 15 * n + 6):
        out[c] = 0.0
    stages.calc_kinematics(
        poses[0:n], lower, upper, R, p_WB, out[6 * n + 6 : 12 * n + 6], J, J_L
    )
    if with_torso:
        _copy_state(poses[n], V[n], pair[7:14], pair[20:26])
        quaternion_to_matrix(pair[7:11], R_WT)
    if with_pads:
        for i in range(n):
            if contact[i, 0] == 0.0 and contact[i, 1] == 0.0:
                continue
            _copy_state(poses[i], V[i], pair[0:7], pair[14:20])
            blocks.add_pads_at(
                pair, R[i], R_WT, contact[i], pads[i], F[i], F_T_W, f_T_W[i]
            )
    if with_legs:
        _add_legs(J, J_L, V[0:n], u, law[3 : 3 + 6 * n], rates, f, F)
    if with_torso:
        displacement = out[15 * n + 6 : 15 * n + 12]
        posture = law[law.shape[0] - 12 :]
        blocks.add_posture(pair, law[0:3], posture, displacement, F_T_W)


@compiled_maker
def add_brace_legs(inputs, n, out):
    """Adds the legs' forces to what `calc_brace` has left them out of.

    Args:
        inputs: As there, with torso; commands alone may have changed since.
        n: Number of stages.
        out: As `calc_brace` has written it, `with_legs` false.
    """
    size = 13 * n + 13
    V = inputs[7 * n + 7 : size].reshape((n + 1, 6))
    u, law = inputs[size : size + 6 * n], inputs[size + 6 * n :]
    J, J_L, rates, f, _, _, _, _, _ = _take_work(out, n)
    F = out[0 : 6 * n].reshape((n, 6))
    _add_legs(J, J_L, V[0:n], u, law[3 : 3 + 6 * n], rates, f, F)


@compiled_maker
def advance_tick(measured, desired, noise, law, tick):
    """One tick of PIC: from readings to commands, `advance_brace_pic`.

    Args:
        measured: Leg lengths (6 n), m, force of each ring on the torso (3 n),
            N, marker (3), m: (9 n + 3,).
        desired: X_d, X_d', X_d'' (18 n,).
        noise: Standard normal draws (9 n + 3,), or (0,) for exact readings.
        law: See `num_tick_law`.
        tick: See `tick_sizes`, updated.

    Returns:
        As `brace_control.advance_brace_pic`.
    """
    size = measured.shape[0]
    n = (size - 3) // 9
    nc = 6 * n
    readings = tick[nc : nc + size]
    readings[:] = measured
    if noise.shape[0] > 0:
        blocks.read_instruments(law[0:2], noise * law[2 : 2 + size], readings)
    at = nc + size
    rows = law[2 + size :].reshape((brace_control.NUM_SHARED_LAW, nc))
    return brace_control.advance_brace_pic(
        readings[0:nc],
        readings[nc : 9 * n],
        desired.reshape((3, nc)),
        rows,
        brace_control.take_geometry(rows, n),
        tick[at + 42 * n :].reshape((n, NUM_POSE_MEMORY)),
        tick[at + 36 * n : at + 42 * n],
        tick[at : at + 18 * n].reshape((3, nc)),
        tick[at + 18 * n : at + 36 * n].reshape((3, nc)),
        brace_control.take_work(n),
        tick[0:nc],
    )
