"""A leg: a massless drive with friction, perhaps a soft or loose joint.

The drive delivers a part of its command, less friction and viscous drag. Where
the joint to the ring is rigid the drive moves with the ring's anchor. Where it
is soft or has play, the drive moves by itself, q, and hands on the force of the
joint, f = K(q - l), zero within the play. Without mass it obeys
b q' = u - F - f, solved for q'; the encoder reads q.

Friction is that of an elasto-plastic bristle (Dupont, Hayward, Armstrong and
Altpeter, "Single state elastoplastic friction models", IEEE Trans. Automatic
Control 47(5), 2002). Its deflection z follows z' = v (1 - a(z, v) z / z_s),
friction is s0 z + s1 z'. Below a part of the deflection of sliding
z_s = F_s(v) / s0 nothing slips (a = 0), so it sticks without creep, unlike
LuGre. F_s falls with speed from breakaway to sliding friction,
F_c + F_b exp(-(|v| / v_s)^p) (Stribeck). The bristle's stiffness is such that
it breaks away after the same travel at any friction.
"""

import math

from brace_drake.withheld.simulator.compiled import worker
from brace_drake.withheld.simulator.frame import leg_geometry
from brace_drake.withheld.simulator.numbers import LEG_LIMIT, LEG_VISCOUS
from brace_drake.withheld.simulator.state import BRISTLE, DRIVE

HARD = 4.0e5  # N/m, a joint with play but no softness of its own
TRAVEL = 8.0e-6  # m, from rest to sliding
DAMPING_TIME = 1.0e-3  # s, damping over stiffness
STUCK = 0.6  # part of z_s below which nothing slips


@worker
def bristle_stiffness(coulomb, breakaway):
    """Stiffness s0, N/m."""
    return (coulomb + breakaway) / TRAVEL


@worker
def sliding_friction(v, coulomb, breakaway, speed, shape):
    """Friction in steady sliding, N, not negative."""
    if breakaway == 0.0:
        return coulomb
    return coulomb + breakaway * math.exp(-((abs(v) / speed) ** shape))


@worker
def bristle_rate(v, z, sliding, stiffness):
    """Rate of the deflection, m/s."""
    if sliding <= 0.0:
        return 0.0
    z_s = sliding / stiffness
    share = z / z_s if v >= 0.0 else -z / z_s
    if share <= STUCK:
        return v
    if share >= 1.0:
        return v * (1.0 - share)
    a = 0.5 - 0.5 * math.cos(math.pi * (share - STUCK) / (1.0 - STUCK))
    return v * (1.0 - a * share)


@worker
def friction(z, z_rate, stiffness):
    """Force against the motion, N."""
    return stiffness * (z + DAMPING_TIME * z_rate)


@worker
def delivered(command, gain, flaws):
    """Force that a drive makes of its command, N."""
    u = command
    if flaws.deadzone > 0.0:
        u = math.copysign(max(0.0, abs(u) - flaws.deadzone), u)
    limit = min(flaws.limit, LEG_LIMIT)
    return gain * max(-limit, min(limit, u))


@worker
def is_loose(flaws):
    """Whether the drive moves apart from the ring's anchor."""
    return flaws.compliance > 0.0 or flaws.play > 0.0


@worker
def joint_force(stretch, flaws):
    """Force through the joint that is squeezed by `stretch`, N."""
    half = 0.5 * flaws.play
    stiffness = 1.0 / flaws.compliance if flaws.compliance > 0.0 else HARD
    if abs(stretch) <= half:
        return 0.0
    return stiffness * (stretch - math.copysign(half, stretch))


@worker
def joint_stretch(force, flaws):
    """How far the joint gives way under a force, m."""
    if force == 0.0:
        return 0.0
    return flaws.compliance * force + math.copysign(0.5 * flaws.play, force)


@worker
def leg_force(u, q, length, rate, z, flaws):
    """Force of a leg on the ring and the rates of its memory.

    Args:
        u: What the drive delivers, N.
        q: Drive's position, m, used where the joint is loose.
        length, rate: Distance of the anchors, m, and its rate, m/s.
        z: Bristle's deflection, m.
        flaws: LegFlaws.

    Returns:
        Force, N, and the rates of q and z, m/s.
    """
    viscous = LEG_VISCOUS + flaws.viscous
    if flaws.cogging > 0.0:
        u = u + flaws.cogging * math.sin(2.0 * math.pi * length / flaws.pitch)
    stiffness = bristle_stiffness(flaws.coulomb, flaws.breakaway)
    v = rate
    through = 0.0
    if is_loose(flaws):
        through = joint_force(q - length, flaws)
        v = (u - through - stiffness * z) / viscous
    sliding = 0.0
    if flaws.coulomb > 0.0 or flaws.breakaway > 0.0:
        sliding = sliding_friction(
            v,
            flaws.coulomb,
            flaws.breakaway,
            flaws.stribeck_speed,
            flaws.stribeck_shape,
        )
    z_rate = bristle_rate(v, z, sliding, stiffness)
    if is_loose(flaws):
        return through, v, z_rate
    force = u - viscous * v - flaws.drag * abs(v) * v
    if sliding > 0.0:
        force -= friction(z, z_rate, stiffness)
    return force, v, z_rate


@worker
def leg_wrench(x, R, bench, run, rates):
    """Adds the legs' force and torque on the ring, and writes the rates of
    their memory; R is the ring's rotation.
    """
    length, arm, along, on = run.length, run.arm, run.along, run.on
    lower, upper = bench.anchors
    leg_geometry(x[0:3], R, lower, upper, length, arm, along)
    for k in range(6):
        n0, n1, n2 = along[k, 0], along[k, 1], along[k, 2]
        m0 = arm[k, 1] * n2 - arm[k, 2] * n1
        m1 = arm[k, 2] * n0 - arm[k, 0] * n2
        m2 = arm[k, 0] * n1 - arm[k, 1] * n0
        rate = n0 * x[6] + n1 * x[7] + n2 * x[8]
        rate += m0 * x[9] + m1 * x[10] + m2 * x[11]
        f, q_rate, z_rate = leg_force(
            run.u[k],
            x[DRIVE + k],
            length[k],
            rate,
            x[BRISTLE + k],
            bench.flaws.legs,
        )
        rates[DRIVE + k] = q_rate
        rates[BRISTLE + k] = z_rate
        on[0, 0] += f * n0
        on[0, 1] += f * n1
        on[0, 2] += f * n2
        on[1, 0] += f * m0
        on[1, 1] += f * m1
        on[1, 2] += f * m2
