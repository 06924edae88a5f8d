"""A leg: a massless drive, and perhaps a soft or loose joint to the ring.

The drive delivers a part of its command, less friction and viscous drag. Where
the joint is rigid the drive moves with the ring's anchor. Where it is soft or
has play, the drive moves by itself, q, and hands on the force of the joint,
f = K(q - l), zero within the play. Without mass it obeys
b q' = u - F - f, solved for q'; the encoder reads q.
"""

import math

from brace_drake.withheld.simulator.bristle import (
    bristle_rate,
    bristle_stiffness,
    friction,
    sliding_friction,
)
from brace_drake.withheld.simulator.compiled import worker
from brace_drake.withheld.simulator.numbers import LEG_LIMIT, LEG_VISCOUS

HARD = 4.0e5  # N/m, a joint with play but no softness of its own


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
