"""Dry friction that builds up over a short way, as what it holds gives way.

Under an imposed motion the force of every sample is compared, that within this
way too; how long it is differs from machine to machine.
"""

from dataclasses import replace

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.joint.friction_behind_play import (
    gradual_force,
    held_force,
)
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    n = f.shape[0]
    for k in range(n):
        f[k] -= held_force(l[k], p[0], p[0] / p[1], 0.0, k, n, x)
    x[n] = 1.0


@plug("drive")
def _gradual_law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    n = f.shape[0]
    for k in range(n):
        f[k] -= gradual_force(l[k], p[0], p[0] / p[1], k, n, x)
    x[n] = 1.0


PRESLIDING = EffectParameter(
    "presliding_m",
    "m",
    1e-7,
    0.01,
    (1e-5, 5e-4),
    "way w over which the force builds up",
    off=None,
)
CARD = Effect(
    name="coulomb_friction",
    form="with presliding",
    block="actuation",
    title="dry friction",
    equation="F = F_c (y - s) / w; s slides where |F| would pass F_c",
    source="Jenkins element: Gaul and Nitsche, The role of friction in"
    " mechanical joints, Applied Mechanics Reviews 54, 2001",
    parameters=(
        EffectParameter(
            "coulomb_N", "N", 0.0, 60.0, (0.5, 8.0), "dry friction F_c"
        ),
        PRESLIDING,
    ),
    laws={"drive": _law},
    num_states={"drive": 7},
    needs=("one joint", "imposed motion"),
    signature="the force steps by twice the friction at every reversal, over a"
    " short way",
    impostors={
        "viscous_friction": "grows with speed; compare slow and fast runs"
    },
    remedy="clean and grease guides and bearings, or compensate the friction",
    experiment="slow reversals",
)

# Contacts of many points let go one after the other.
GRADUAL = replace(
    CARD,
    form="gradual",
    title="dry friction that builds up bit by bit",
    equation="dF / dy = (F_c - F sign(y')) / w",
    source="Dahl, Solid friction damping of mechanical vibrations, AIAA Journal"
    " 14, 1976",
    laws={"drive": _gradual_law},
    needs=("one joint", "presliding"),
)

CARDS = (CARD, GRADUAL)
