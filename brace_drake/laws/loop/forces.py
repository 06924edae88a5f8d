"""All forces on the bodies of a brace, with the effects in between.

The one place where legs, pads, posture and the effects at their plug points
are put together. `effects` are as `laws.hooks` has them, `numbers` and
`brace` as `laws.numbers` and `laws.loop.brace`; effects advance their states
by `dt`.
"""

from brace_drake.laws import contact, stages
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import (
    COMPRESSION,
    CONTACT,
    DRIVE,
    MAX_EFFECTS,
    RING,
    TORSO,
)
from brace_drake.laws.lanes.functions import lead, some, where
from brace_drake.laws.loop.effect_calls import (
    call_compression,
    call_contact,
    call_drive,
    call_ring,
    call_torso,
)
from brace_drake.laws.posture import add_posture_force
from brace_drake.laws.rotation import (
    quaternion_to_matrix,
    quaternion_to_rotation_vector,
)


@compiled_law
def calc_displacement(pose, rest, displacement):
    """Writes displacement from rest (3), m, and rotation vector (3), rad."""
    for c in range(3):
        displacement[c] = pose[4 + c] - rest[c]
    quaternion_to_rotation_vector(pose[0:4], displacement[3:6])


@compiled_law
def press_pad(t, dt, i, pad, numbers, effects, brace):
    """Adds the forces of a pad of ring i, none where it is off or would pull.

    `brace.pad` takes `contact.calc_compression` (14), then d, d', N.

    Args:
        t, dt: s.
        i: Ring.
        pad: 0 at +y, 1 at -y.
        numbers, effects, brace: See the module.
    """
    n, o, law = numbers.rest.shape[0], brace.pad, numbers.contact[i]
    poses, V, R, side = brace.poses, brace.V, brace.R, 1.0 - 2.0 * pad
    contact.calc_compression(
        side, law[4], law[5], poses[i, 4:7], R[i], V[i], poses[n, 4:7], R[n],
        V[n], o,
    )  # fmt: skip
    o[14], o[15] = o[0], o[1]
    for e in range(MAX_EFFECTS):
        if effects.active[COMPRESSION, e]:
            call_compression(effects, e, i, t, dt, pad, o[14:16])
    o[16] = contact.normal_force(o[14], o[15], law[0], law[1])
    for e in range(MAX_EFFECTS):
        if effects.active[CONTACT, e]:
            call_contact(effects, e, i, t, dt, pad, o[14:16], law, o[16:17])
    presses = (o[14] > 0.0) & (o[16] > 0.0)
    if some(presses):
        contact.add_pad_forces(
            side, where(presses, o[16], 0.0), law[2], law[3], o, brace.F[i],
            brace.F[n], brace.f_T[i],
        )  # fmt: skip


@compiled_law
def press_pads(t, dt, numbers, effects, brace):
    """Leg kinematics, then the pads' forces: nothing depends on commands.

    What was in `brace.F` and `brace.f_T` is overwritten.
    """
    n = numbers.rest.shape[0]
    stages.calc_kinematics(
        brace.poses[0:n], numbers.lower, numbers.upper, brace.R, brace.p_WB,
        brace.lengths, brace.J, brace.J_L,
    )  # fmt: skip
    stages.calc_rates(brace.J, brace.J_L, brace.V, brace.rates)
    for i in range(n + 1):
        brace.F[i, :] = 0.0
    for i in range(n):
        brace.f_T[i, :] = 0.0
    if not brace.present[0]:
        return
    quaternion_to_matrix(brace.poses[n, 0:4], brace.R[n])
    for i in range(n):
        law = numbers.contact[i]
        if lead(law[0]) != 0.0 or lead(law[1]) != 0.0:
            for pad in range(2):
                press_pad(t, dt, i, pad, numbers, effects, brace)


@compiled_law
def drive_legs(t, dt, numbers, effects, brace):
    """Adds what the legs' forces, f = u - viscous l', do to the rings."""
    n, viscous, f = numbers.rest.shape[0], numbers.viscous, brace.f
    for k in range(6 * n):
        f[k] = brace.u[k] - viscous[k] * brace.rates[k]
    for e in range(MAX_EFFECTS):
        if effects.active[DRIVE, e]:
            for i in range(n):
                a, b = 6 * i, 6 * i + 6
                call_drive(
                    effects, e, i, t, dt, brace.u[a:b], brace.lengths[a:b],
                    brace.rates[a:b], viscous[a:b], f[a:b],
                )  # fmt: skip
    stages.add_wrenches(brace.J, brace.J_L, f, brace.F)


@compiled_law
def push_rings(t, dt, numbers, effects, brace):
    """Adds what effects at the rings put on them."""
    at = brace.displacement
    for e in range(MAX_EFFECTS):
        if effects.active[RING, e]:
            for i in range(numbers.rest.shape[0]):
                calc_displacement(brace.poses[i], numbers.rest[i], at)
                call_ring(
                    effects, e, i, t, dt, at[0:3], at[3:6], brace.V[i],
                    brace.F[i],
                )  # fmt: skip


@compiled_law
def hold_torso(t, dt, numbers, effects, brace):
    """Adds the posture's bushing, and effects at the torso."""
    n, at = numbers.rest.shape[0], brace.displacement
    V, F = brace.V[n], brace.F[n]
    calc_displacement(brace.poses[n], numbers.torso_rest, at)
    add_posture_force(at[0:3], at[3:6], V, numbers.posture, F)
    for e in range(MAX_EFFECTS):
        if effects.active[TORSO, e]:
            call_torso(
                effects, e, t, dt, at[0:3], at[3:6], V, numbers.posture, F
            )


@compiled_law
def add_forces(t, dt, numbers, effects, brace):
    """Adds all other forces to those of the pads; weight is left out."""
    if brace.present[1]:
        drive_legs(t, dt, numbers, effects, brace)
    push_rings(t, dt, numbers, effects, brace)
    if brace.present[0]:
        hold_torso(t, dt, numbers, effects, brace)
