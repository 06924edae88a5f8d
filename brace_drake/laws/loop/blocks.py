"""Blocks of the bench: nominal laws put together, and with their effects.

The nominal forms are what a LeafSystem calls where no effect sits at its plug
points. The hooked forms are the same with the effects' laws in between; they
are compiled into the rollout (a LeafSystem calls the effects one by one, as
handing functions to compiled code costs more than the laws themselves).
"""

import numpy as np

from brace_drake.laws import contact, legs, posture
from brace_drake.laws.compiled import compiled_law, compiled_maker
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.laws.reading import read_instrument
from brace_drake.laws.rotation import (
    quaternion_to_matrix,
    quaternion_to_rotation_vector,
)


@compiled_maker
def calc_ring_kinematics(q_WR, p_WR, V_WR, p_WB, p_RT, lengths, rates, J):
    """Writes leg lengths, rates and Jacobian of a ring (see `legs`)."""
    R_WR = np.empty((3, 3))
    quaternion_to_matrix(q_WR, R_WR)
    legs.calc_leg_kinematics(p_WR, R_WR, p_WB, p_RT, lengths, J)
    legs.calc_leg_rates(J, V_WR[0:3], V_WR[3:6], rates)


@compiled_law
def calc_leg_forces(u, viscous, rates, f):
    """Writes the force of each leg, f = u - viscous l', N, all (n,)."""
    for k in range(f.shape[0]):
        f[k] = u[k] - viscous[k] * rates[k]


@compiled_law
def calc_pad_at(pad, bodies, R_WR, R_WT, law, o):
    """`calc_pad` where the rotation matrices (3, 3) are at hand."""
    contact.calc_compression(
        1.0 - 2.0 * pad,
        law[4],
        law[5],
        bodies[4:7],
        R_WR,
        bodies[14:20],
        bodies[11:14],
        R_WT,
        bodies[20:26],
        o,
    )
    o[14] = o[0]
    o[15] = o[1]


@compiled_maker
def calc_pad(pad, bodies, law, o):
    """Writes the geometry of one pad and d, d' of its contact.

    Args:
        pad: 0 at +y, 1 at -y.
        bodies: q_WR, p_WR, q_WT, p_WT, V_WR, V_WT (26,).
        law: Stiffness, damping, friction, regularisation speed, pad offset,
            preload (6,).
        o: Output (17,): `contact.calc_compression`, then d, d', then a place
            for the normal force.
    """
    R_WR, R_WT = np.empty((3, 3)), np.empty((3, 3))
    quaternion_to_matrix(bodies[0:4], R_WR)
    quaternion_to_matrix(bodies[7:11], R_WT)
    calc_pad_at(pad, bodies, R_WR, R_WT, law, o)


@compiled_law
def calc_pad_normal_force(law, o):
    """Writes N = k d + c d', not yet cut at zero, from d, d' in o (17,)."""
    o[16] = contact.normal_force(o[14], o[15], law[0], law[1])


@compiled_law
def add_pad_force(pad, law, o, F_R_W, F_T_W, f_T_W):
    """Adds the forces of one pad, none where it is off or would pull.

    Args:
        pad, law, o: As in `calc_pad`, with N in its place.
        F_R_W, F_T_W: Spatial forces (6,), torque first, added to.
        f_T_W: Force of the ring on the torso (3,), added to.
    """
    if o[14] > 0.0 and o[16] > 0.0:
        contact.add_pad_forces(
            1.0 - 2.0 * pad, o[16], law[2], law[3], o, F_R_W, F_T_W, f_T_W
        )


@compiled_law
def add_pads_at(bodies, R_WR, R_WT, law, pads, F_R_W, F_T_W, f_T_W):
    """`add_nominal_pads` where the rotation matrices (3, 3) are at hand."""
    f_T_W[:] = 0.0
    for pad in range(2):
        calc_pad_at(pad, bodies, R_WR, R_WT, law, pads[pad])
        calc_pad_normal_force(law, pads[pad])
        add_pad_force(pad, law, pads[pad], F_R_W, F_T_W, f_T_W)


@compiled_maker
def add_nominal_pads(bodies, law, pads, F_R_W, F_T_W, f_T_W):
    """Both pads without effects; f_T_W (3,) is overwritten."""
    R_WR, R_WT = np.empty((3, 3)), np.empty((3, 3))
    quaternion_to_matrix(bodies[0:4], R_WR)
    quaternion_to_matrix(bodies[7:11], R_WT)
    add_pads_at(bodies, R_WR, R_WT, law, pads, F_R_W, F_T_W, f_T_W)


@compiled_law
def calc_displacement(q, p, rest, pose):
    """Writes displacement from rest (3), m, and rotation vector (3), rad."""
    for i in range(3):
        pose[i] = p[i] - rest[i]
    quaternion_to_rotation_vector(q, pose[3:6])


@compiled_law
def add_posture(bodies, rest, law, pose, F_T_W):
    """Adds the posture's bushing force to F_T_W (6,), torque first.

    `law` (12,) as in `posture.add_posture_force`; `pose` (6,) takes the
    torso's displacement and rotation vector.
    """
    calc_displacement(bodies[7:11], bodies[11:14], rest, pose)
    posture.add_posture_force(pose[0:3], pose[3:6], bodies[20:26], law, F_T_W)


@compiled_law
def read_instruments(resolution, noise, out):
    """Turns ideal values into readings, in place.

    Args:
        resolution: Of lengths, m, and forces, N; 0 is not rounded (2,).
        noise: Of lengths, forces and marker, as `out`; empty: exact readings,
            neither noisy nor rounded.
        out: Of S stages lengths (6 S), m, forces (3 S), N, marker (3), m.
    """
    if noise.shape[0] == 0:
        return
    end = out.shape[0] - 3
    num_lengths = 2 * end // 3
    for i in range(num_lengths):
        out[i] = read_instrument(out[i], noise[i], resolution[0])
    for i in range(num_lengths, end):
        out[i] = read_instrument(out[i], noise[i], resolution[1])
    for i in range(end, end + 3):
        out[i] += noise[i]


@compiled_law
def add_hooked_pads(
    t,
    dt,
    bodies,
    R_WR,
    R_WT,
    law,
    pads,
    active,
    compression,
    contact_laws,
    parameters,
    compression_memory,
    contact_memory,
    F_R_W,
    F_T_W,
    f_T_W,
):
    """`add_nominal_pads` with the effects at `compression` and `contact`."""
    f_T_W[:] = 0.0
    for pad in range(2):
        o = pads[pad]
        calc_pad_at(pad, bodies, R_WR, R_WT, law, o)
        for e in range(MAX_EFFECTS):
            if not active[1, e]:
                continue
            compression[e](
                t, dt, pad, o[14:16], parameters[e], compression_memory[e]
            )
        calc_pad_normal_force(law, o)
        for e in range(MAX_EFFECTS):
            if not active[2, e]:
                continue
            contact_laws[e](
                t,
                dt,
                pad,
                o[14:16],
                law,
                o[16:17],
                parameters[e],
                contact_memory[e],
            )
        add_pad_force(pad, law, o, F_R_W, F_T_W, f_T_W)
