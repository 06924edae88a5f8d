"""Dry friction that grows with a measured load, pressure or tension."""

from dataclasses import replace

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.joint.friction_behind_play import (
    JOINT_STIFFNESS,
    gradual_force,
    held_force,
)
from brace_drake.effects.joint.friction_with_presliding import (
    GRADUAL as GRADUAL_FRICTION,
)
from brace_drake.effects.joint.friction_with_presliding import PRESLIDING
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug


@compiled_law
def _level(law, p, n):
    # law holds the viscous friction of each joint, then the extra inputs; the
    # axis puts the input's place behind the parameters.
    return p[0] + p[1] * abs(law[n + int(p[3])])


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    n = f.shape[0]
    for k in range(n):
        f[k] -= held_force(l[k], _level(law, p, n), p[2], 0.0, k, n, x)
    x[n] = 1.0


@plug("drive")
def _gradual_law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    n = f.shape[0]
    for k in range(n):
        level = _level(law, p, n)
        f[k] -= gradual_force(l[k], level, level / p[2], k, n, x)
    x[n] = 1.0


CARD = Effect(
    name="load_friction",
    block="actuation",
    title="dry friction that grows with a load",
    equation="F = k (y - s); s slides where |F| would pass F_c + g |i|, i an"
    " extra input",
    source="Bona and Indri, Friction compensation in robotics, an overview,"
    " IEEE Conference on Decision and Control, 2005",
    parameters=(
        EffectParameter(
            "coulomb_N", "N", 0.0, 60.0, (1.0,), "friction F_c without load"
        ),
        EffectParameter(
            "growth_N_input",
            "N/input",
            0.0,
            60.0,
            (1.0,),
            "friction g that each unit of the load adds",
        ),
        JOINT_STIFFNESS,
    ),
    laws={"drive": _law},
    num_states={"drive": 7},
    generalises=("coulomb_friction",),
    needs=("one joint", "extra input"),
    signature="half of the loop between both directions grows with the load",
    impostors={"coulomb_friction": "the same at every load"},
    remedy="check how guides and bearings are aligned and loaded from the side",
    experiment="the same strokes at three loads",
)

# See the same form of Coulomb friction.
GRADUAL = replace(
    CARD,
    form="gradual",
    title="dry friction that builds up bit by bit and grows with a load",
    equation="dF / dy = (F_c + g |i| - F sign(y')) / w, i an extra input",
    source=GRADUAL_FRICTION.source,
    parameters=(*CARD.parameters[:2], PRESLIDING),
    laws={"drive": _gradual_law},
)

CARDS = (CARD, GRADUAL)
