"""Forces of the bench with its effects in between, for compiled rollouts.

`bodies` holds q_WR, p_WR, q_WT, p_WT, V_WR, V_WT (26,). Stacks of laws at the
plug points, their parameters, memories and `active` are as `rollout_bench`
takes them.
"""

from brace_drake.laws import legs
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.laws.loop import blocks
from brace_drake.laws.rotation import quaternion_to_matrix


@compiled_law
def calc_hooked_contact(
    t,
    dt,
    with_torso,
    bodies,
    p_WB,
    p_RT,
    law,
    active,
    compression,
    contact,
    parameters,
    compression_memory,
    contact_memory,
    R_WR,
    R_WT,
    lengths,
    rates,
    J,
    pads,
    F_R_W,
    F_T_W,
    f_T_W,
):
    """Leg kinematics, then the pads' forces; nothing depends on commands.

    Overwrites rotations (3, 3), leg lengths and rates (6,), Jacobian (6, 6),
    pads (2, 17), spatial forces (6,), torque first, and f_T_W (3,).
    """
    quaternion_to_matrix(bodies[0:4], R_WR)
    quaternion_to_matrix(bodies[7:11], R_WT)
    legs.calc_leg_kinematics(bodies[4:7], R_WR, p_WB, p_RT, lengths, J)
    legs.calc_leg_rates(J, bodies[14:17], bodies[17:20], rates)
    F_R_W[:] = 0.0
    F_T_W[:] = 0.0
    if with_torso:
        blocks.add_hooked_pads(
            t, dt, bodies, R_WR, R_WT, law, pads, active, compression,
            contact, parameters, compression_memory, contact_memory, F_R_W,
            F_T_W, f_T_W,
        )  # fmt: skip


@compiled_law
def read_hooked(
    t, period, u, resolution, noise, active, sensing, parameters, memory, out
):
    """Turns ideal values (12,) into readings: effects, noise, rounding."""
    for e in range(MAX_EFFECTS):
        if not active[5, e]:
            continue
        sensing[e](t, period, u, out[0:6], out[6:9], parameters[e], memory[e])
    blocks.read_instruments(resolution, noise, out)


@compiled_law
def add_hooked_forces(
    t,
    dt,
    with_torso,
    u,
    bodies,
    lengths,
    rates,
    J,
    rest,
    viscous,
    posture,
    active,
    drive,
    torso,
    ring,
    parameters,
    drive_memory,
    torso_memory,
    ring_memory,
    f,
    pose,
    F_R_W,
    F_T_W,
):
    """Adds what legs and posture put on ring and torso to the pads' forces.

    The ring's weight is left out. `f` and `pose` (6,) are places to work in.
    """
    V_WR, V_WT = bodies[14:20], bodies[20:26]
    blocks.calc_leg_forces(u, viscous, rates, f)
    for e in range(MAX_EFFECTS):
        if not active[0, e]:
            continue
        drive[e](
            t, dt, u, lengths, rates, viscous, f,
            parameters[e], drive_memory[e],
        )  # fmt: skip
    legs.add_leg_wrench(J, f, F_R_W)
    placed = False
    for e in range(MAX_EFFECTS):
        if not active[4, e]:
            continue
        if not placed:
            blocks.calc_displacement(bodies[0:4], bodies[4:7], rest, pose)
            placed = True
        ring[e](
            t, dt, pose[0:3], pose[3:6], V_WR, F_R_W,
            parameters[e], ring_memory[e],
        )  # fmt: skip
    if not with_torso:
        return
    blocks.add_posture(bodies, rest, posture, pose, F_T_W)
    for e in range(MAX_EFFECTS):
        if not active[3, e]:
            continue
        torso[e](
            t, dt, pose[0:3], pose[3:6], V_WT, posture, F_T_W,
            parameters[e], torso_memory[e],
        )  # fmt: skip
