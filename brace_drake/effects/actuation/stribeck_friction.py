"""Dry friction that is larger at rest than in motion."""

import math
from dataclasses import replace

from brace_drake.effects.actuation.coulomb_friction import (
    STUCK,
    bristle_force,
    or_one,
    resisting,
    sign_of,
)
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.elementary import exp
from brace_drake.laws.lanes.functions import where


@compiled_law
def _resist(dt, l_dot, p, stuck, f, x):
    # x[k]: deflection of the bristles of leg k.
    top = or_one(p[0] + p[1])
    for k in range(f.shape[0]):
        part = l_dot[k] / p[2]
        level = p[0] + p[1] * exp(-part * part)
        force = bristle_force(dt, l_dot[k], or_one(level), top, k, x, stuck)
        f[k] = where(level > 0.0, f[k] - force, f[k])


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    _resist(dt, l_dot, p, 0.0, f, x)


@plug("drive", lanes=True)
def _law_without_creep(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    _resist(dt, l_dot, p, STUCK, f, x)


CARD = Effect(
    name="stribeck_friction",
    block="actuation",
    title="dry friction with a higher breakaway force",
    equation="g(l') = F_c + F_b exp(-(l' / v_s)^2) in place of F_c, otherwise"
    " as Coulomb friction with bristles, s_0 = (F_c + F_b) / 5 um",
    source="Canudas de Wit, Olsson, Astrom, Lischinsky, A new model for"
    " control of systems with friction, IEEE Trans. Autom. Control 40, 1995",
    parameters=(
        EffectParameter(
            "coulomb_N", "N", 0.0, 60.0, (0.5,), "friction force in motion F_c"
        ),
        EffectParameter(
            "breakaway_N",
            "N",
            0.0,
            60.0,
            (0.5,),
            "additional force at rest F_b",
        ),
        EffectParameter(
            "stribeck_velocity_m_s",
            "m/s",
            2e-4,
            0.05,
            (0.002,),
            "speed v_s at which most of it is gone",
            off=None,
        ),
    ),
    laws={"drive": _law},
    num_states={"drive": 6},
    needs=("drive of its own",),
    dithered=True,
    generalises=("coulomb_friction",),
    signature="stick and slip: a jump of the ring after every reversal",
    impostors={
        "coulomb_friction": "no negative slope; compare several slow speeds"
    },
    remedy="clean and grease guides and screws; until then avoid rests and"
    " very slow reversals",
    experiment="reversals at several slow speeds without contact",
)

# See the same form of Coulomb friction.
WITHOUT_CREEP = replace(
    CARD,
    form="without creep",
    title="dry friction with a higher breakaway force that holds without creep",
    equation="g(l') = F_c + F_b exp(-(l' / v_s)^2) in place of F_c, otherwise"
    " as Coulomb friction without creep",
    source="Dupont, Hayward, Armstrong, Altpeter, Single state elastoplastic"
    " friction models, IEEE Trans. Autom. Control 47, 2002",
    laws={"drive": _law_without_creep},
)


@plug("drive")
def _law_of_joint(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    for k in range(f.shape[0]):
        slow = math.exp(-((l_dot[k] / p[2]) ** 2))
        f[k] -= (p[0] + p[1] * slow) * sign_of(l_dot[k])


OF_JOINT = replace(
    CARD,
    form="joint",
    title="dry friction of a joint with a higher breakaway force",
    equation="F = (F_c + F_b exp(-(y' / v_s)^2)) sign(y')",
    laws={"drive": _law_of_joint},
    num_states={},
    needs=("joint of a plant",),
)


@plug("drive")
def _law_that_stops(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    for k in range(f.shape[0]):
        slow = math.exp(-((l_dot[k] / p[2]) ** 2))
        f[k] += resisting(dt, l_dot[k], f[k], p[0] + p[1] * slow)


# See the same form of Coulomb friction.
THAT_STOPS = replace(
    OF_JOINT,
    form="that stops",
    title="dry friction of a drive with a higher breakaway force",
    source="Karnopp, Computer simulation of stick-slip friction, J. Dyn. Syst."
    " Meas. Control 107, 1985",
    laws={"drive": _law_that_stops},
    needs=("sum of forces",),
)

CARDS = (CARD, WITHOUT_CREEP, OF_JOINT, THAT_STOPS)
