"""A drive that is not rigidly joined to the ring, and sticks.

Its dry friction acts between drive and base: it holds the drive, while the ring
still moves by what the joint between them lets it. In the balance of the drive,
b v = u - f_joint - F_c(v), the drive has no mass. Friction is that of bristles
without creep, as where the drive is rigidly joined: see `coulomb_friction`.
"""

import numpy as np

from brace_drake.effects.actuation.coulomb_friction import (
    STUCK,
    WITHOUT_CREEP_TRAVEL,
    slip_share,
)
from brace_drake.effects.card import EffectParameter
from brace_drake.kinematics import hold_at_rest
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.lanes.elementary import exp
from brace_drake.laws.lanes.functions import where

DRIVE_DRY_FRICTION = EffectParameter(
    "coulomb_N",
    "N",
    0.0,
    60.0,
    (0.03,),
    "dry friction F_c of the drive",
)
# What the form of an effect with a sticking drive is called, and cites.
STICKING = "dry friction"
SOURCE = (
    "Dupont, Hayward, Armstrong, Altpeter, Single state elastoplastic"
    " friction models, IEEE Trans. Autom. Control 47, 2002"
)


def drives_at_rest(numbers) -> np.ndarray:
    """Viscous friction of each drive, N s/m, then what each leg carries at
    rest, N: (n, 12), a row for each stage.

    Args:
        numbers: See `laws.numbers`.
    """
    viscous = numbers.viscous.reshape(-1, 6)
    return np.hstack([viscous, hold_at_rest(numbers)])


@compiled_law
def follow_share(push, level, z):
    """Share of a move that the bristles follow, 0 to 1: the rest slips.

    z' = v (1 - a |z| / z_s), see `coulomb_friction.slip_share`.

    Args:
        push: What moves the drive, N; it goes that way.
        level: F_c, N.
        z: Deflection of its bristles, m.
    """
    top = WITHOUT_CREEP_TRAVEL
    speed = push - level / top * z
    return 1.0 - slip_share(speed, z, top, STUCK) * abs(z) / top


@compiled_law
def friction_held(dt, push, drag, level, z, follow):
    """Dry friction of a drive without mass over a step, N.

    Args:
        dt: s.
        push: What moves the drive if it stood, N.
        drag: What it is slowed by, N s/m, above 0.
        level: F_c, N.
        z: Deflection of its bristles, m.
        follow: Share of a move that they follow.
    """
    stiffness = level / WITHOUT_CREEP_TRAVEL
    part = follow * dt
    held = push - stiffness * z
    force = stiffness * (z + part * held / (drag + part * stiffness))
    return min(max(force, -level), level)


@compiled_law
def deflect(z, move):
    """Deflection of bristles after they have followed a move, m."""
    top = WITHOUT_CREEP_TRAVEL
    return min(max(z + move, -top), top)


@compiled_law
def yield_elastic(dt, u, l_dot, b, c, level, stretch, z):
    """An elastic leg over a step: its stretch at the end and on average, m,
    and the deflection of the drive's bristles.

    c b e' = c (u - F - b l') - e, exactly for a constant F.

    Args:
        dt: s.
        u: Command, N.
        l_dot: Rate of the leg, m/s.
        b: Viscous friction of the drive, N s/m.
        c: Compliance, m/N.
        level: Dry friction of the drive F_c, N.
        stretch: e = l_drive - l, m.
        z: Deflection of the bristles, m.
    """
    # While the drive stands the spring follows the ring.
    push = u - (stretch - dt * l_dot) / c
    follow = follow_share(push, level, z)
    force = friction_held(dt, push, b + dt / c, level, z, follow)
    balanced = c * (u - force - b * l_dot)
    rate = dt / max(c * b, 1e-12)
    decay = exp(-rate)
    # The exact mean over the step keeps a stiff spring stable.
    mean = balanced + (stretch - balanced) * (1.0 - decay) / rate
    end = balanced + (stretch - balanced) * decay
    return end, mean, deflect(z, follow * (dt * l_dot + end - stretch))


@compiled_law
def run_in_gap(dt, u, l_dot, b, half, level, place, z):
    """A drive in its gap over a step: its place at the end, m, the force that
    an end of the gap passes, N, and the deflection of its bristles.

    Args:
        dt, u, l_dot, b, level, z: As of `yield_elastic`; b above 0.
        half: Of the gap's width, m.
        place: g = l_drive - l, m.
    """
    follow = follow_share(u, level, z)
    force = friction_held(dt, u, b, level, z, follow)
    free = place + dt * ((u - force) / b - l_dot)
    end = min(max(free, -half), half)
    after = deflect(z, follow * (dt * l_dot + end - place))
    passed = b * (free - end) / dt
    # The bristles move with the end of the gap, not as if it were free.
    held = force - level / WITHOUT_CREEP_TRAVEL * after
    return end, where(free != end, passed + held, passed), after
