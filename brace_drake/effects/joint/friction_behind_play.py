"""Dry friction that is reached through play and an elastic joint."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug


@compiled_law
def held_force(position, level, stiffness, play, k, n, x):
    """Force of dry friction behind an elastic joint with play, N.

    Args:
        position: Of the joint, m.
        level: Friction that is held at most, N.
        stiffness: Of the joint, N/m, above 0.
        play: Its width, m.
        k, n: The joint's place among n.
        x: Place of each joint's friction (n), advanced, and whether they are
            known; a run begins in the middle of the play.
    """
    if x[n] == 0.0:
        x[k] = position
    way = position - x[k]
    force = stiffness * (way - min(max(way, -0.5 * play), 0.5 * play))
    held = min(max(force, -level), level)
    # What cannot be held moves the friction along.
    x[k] += (force - held) / stiffness
    return held


@compiled_law
def gradual_force(position, level, stiffness, k, n, x):
    """Force of dry friction that builds up bit by bit, N.

    dF / dy = k (1 - F sign(y') / F_c), along any way: exp(-way k / F_c) of what
    lacks is left after it.

    Args:
        position: Of the joint, m.
        level: Friction F_c that is reached in the end, N.
        stiffness: Slope at a rest without force, N/m, above 0.
        k, n: The joint's place among n.
        x: Force of each joint (n), whether their places are known, and these
            (n), advanced.
    """
    way = position - (x[n + 1 + k] if x[n] > 0.0 else position)
    x[n + 1 + k] = position
    if level > 0.0:
        end = level if way > 0.0 else -level
        x[k] = end + (x[k] - end) * math.exp(-stiffness * abs(way) / level)
    else:
        x[k] = 0.0
    return x[k]


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    n = f.shape[0]
    for k in range(n):
        f[k] -= held_force(l[k], p[0], p[1], p[2], k, n, x)
    x[n] = 1.0


JOINT_STIFFNESS = EffectParameter(
    "stiffness_N_m",
    "N/m",
    10.0,
    1e6,
    (2e3, 2e4),
    "stiffness k of the joint",
    off=None,
)
CARD = Effect(
    name="friction_behind_play",
    block="actuation",
    title="dry friction behind play and an elastic joint",
    equation="F = k (y - s) outside of play of width w, none inside; s slides"
    " where |F| would pass F_c",
    source="Jenkins element with a gap: Gaul and Nitsche, The role of friction"
    " in mechanical joints, Applied Mechanics Reviews 54, 2001; play: Nordin"
    " and Gutman, Automatica 38, 2002",
    parameters=(
        EffectParameter(
            "coulomb_N", "N", 0.0, 60.0, (2.0, 8.0), "dry friction F_c"
        ),
        JOINT_STIFFNESS,
        EffectParameter(
            "backlash_m",
            "m",
            0.0,
            0.02,
            (5e-4, 3e-3),
            "width w of the play",
            off=None,
        ),
    ),
    laws={"drive": _law},
    num_states={"drive": 7},
    generalises=("coulomb_friction", "joint_spring"),
    needs=("one joint",),
    signature="no force over a constant way after each reversal, then a steep"
    " rise to a level",
    impostors={
        "coulomb_friction": "the level is reached at once after a reversal"
    },
    remedy="tighten the joint, and grease what moves behind it",
    experiment="slow strokes of two lengths",
)
