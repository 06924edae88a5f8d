"""Dry friction in the drives of the legs."""

import math
from dataclasses import replace

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.elementary import sin
from brace_drake.laws.lanes.functions import some, where

# Before sliding: bristles give way by a few micrometres, those without creep by
# what the bench's friction within its tolerance does, and are well damped; the
# caps keep an explicit plant step stable.
_PRESLIDING, WITHOUT_CREEP_TRAVEL = 5e-6, 1e-5  # m
_DAMPING_TIME = 1.5e-3  # s
_MAX_STIFFNESS = 1e6  # N/m
_MAX_DAMPING = 600.0  # N s/m
# Part of the deflection of sliding up to which nothing slips, without creep.
STUCK = 0.7
_QUARTER_TURN = 0.5 * math.pi


@compiled_law
def slip_share(speed, z, sliding, stuck):
    """Share a of the bristles' deflection that slips, 0 to 1.

    Without a part that is stuck all slips at any load (LuGre), and a drive
    that trembles creeps. Otherwise nothing does up to that part of the
    deflection of sliding, and on the way back (Dupont, Hayward, Armstrong,
    Altpeter, Single state elastoplastic friction models, IEEE Trans. Autom.
    Control 47, 2002, equations 11 and 12).

    Args:
        speed: v, m/s.
        z: Deflection, m.
        sliding: That of steady sliding, g / s_0, m.
        stuck: The part that does not slip, below 1.
    """
    if stuck <= 0.0:
        return 1.0
    # 0 at the part that is stuck, a quarter turn where all slips; the share is
    # the square of its sine.
    turn = (abs(z) / sliding - stuck) * (_QUARTER_TURN / (1.0 - stuck))
    turn = min(max(turn, 0.0), _QUARTER_TURN)
    is_most = turn > 0.5 * _QUARTER_TURN
    sine = sin(where(is_most, _QUARTER_TURN - turn, turn))
    share = where(is_most, 1.0 - sine * sine, sine * sine)
    return where(z * speed <= 0.0, 0.0, share)


@compiled_law
def bristle_force(dt, speed, level, top, k, x, stuck=0.0):
    """Friction force of leg k, N; its bristles' deflection x[k] is advanced.

    z' = v - a s_0 |v| z / g, F = s_0 z + s_1 z', integrated implicitly, with
    s_0 the same at any speed: a force that falls with speed does so after
    some travel, not at once.

    Args:
        dt: s.
        speed: v, m/s.
        level: g, the force when sliding at that speed, N, above 0; of copies
            without friction see `or_one`.
        top: Largest g, at rest, N.
        k: Index of the leg.
        x: Deflections, m.
        stuck: Part of the deflection of sliding up to which a is 0, see
            `slip_share`.
    """
    travel = WITHOUT_CREEP_TRAVEL if stuck > 0.0 else _PRESLIDING
    stiffness = min(top / travel, _MAX_STIFFNESS)
    damping = min(_DAMPING_TIME * stiffness, _MAX_DAMPING)
    share = slip_share(speed, x[k], level / stiffness, stuck)
    grip = 1.0 + dt * share * stiffness * abs(speed) / level
    z = (x[k] + dt * speed) / grip
    force = stiffness * z + damping * (z - x[k]) / dt
    x[k] = z
    return force


@compiled_law
def or_one(level):
    """A friction force, 1 N where there is none: it can be divided by."""
    return where(level > 0.0, level, 1.0)


@compiled_law
def _resist(dt, l_dot, p, stuck, f, x):
    # x[k]: deflection of the bristles of leg k.
    acts = p[0] > 0.0
    if some(acts):
        level = or_one(p[0])
        for k in range(f.shape[0]):
            force = bristle_force(dt, l_dot[k], level, level, k, x, stuck)
            f[k] = where(acts, f[k] - force, f[k])


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    _resist(dt, l_dot, p, 0.0, f, x)


@plug("drive", lanes=True)
def _law_without_creep(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    _resist(dt, l_dot, p, STUCK, f, x)


CARD = Effect(
    name="coulomb_friction",
    block="actuation",
    title="dry friction",
    equation="f = u - b l' - s_0 z - s_1 z', z' = l' - s_0 |l'| z / F_c"
    " (LuGre bristles without Stribeck effect: F_c sign(l') when sliding;"
    " s_0 = F_c / 5 um, s_1 = s_0 1.5 ms, both capped)",
    source="Canudas de Wit, Olsson, Astrom, Lischinsky, A new model for"
    " control of systems with friction, IEEE Trans. Autom. Control 40, 1995",
    parameters=(
        EffectParameter(
            "coulomb_N", "N", 0.0, 60.0, (0.5,), "friction force of one leg"
        ),
    ),
    laws={"drive": _law},
    num_states={"drive": 6},
    needs=("drive of its own",),
    dithered=True,
    signature="commands step by twice the friction at every reversal; a free"
    " run shows it as clearly as a push",
    impostors={
        "viscous_leg": "grows with speed; compare slow and fast runs",
        "command_delay": "no step at reversals; grows with acceleration",
    },
    remedy="move each drive by hand with the power off; clean and grease"
    " guides and screws, or compensate the friction",
    experiment="slow reversals without contact",
)

# Under noise in the loop bristles that always slip a bit let a drive creep
# below its friction; real contacts do not.
WITHOUT_CREEP = replace(
    CARD,
    form="without creep",
    title="dry friction that holds without creep",
    equation="f = u - b l' - s_0 z - s_1 z', z' = l' - a s_0 |l'| z / F_c"
    " (elasto-plastic bristles: a = 0, nothing slips, up to 0.7 of the"
    " deflection of sliding, s_0 = F_c / 10 um; otherwise as the other form)",
    source="Dupont, Hayward, Armstrong, Altpeter, Single state elastoplastic"
    " friction models, IEEE Trans. Autom. Control 47, 2002",
    laws={"drive": _law_without_creep},
)

# A plant's joint takes the force at the end of a step: it holds by itself.
_STANDS_M_S = 1e-6


@compiled_law
def sign_of(speed):
    """Direction of a speed, in proportion to it where it stands."""
    return min(max(speed / _STANDS_M_S, -1.0), 1.0)


@plug("drive")
def _law_of_joint(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    for k in range(f.shape[0]):
        f[k] -= p[0] * sign_of(l_dot[k])


OF_JOINT = replace(
    CARD,
    form="joint",
    title="dry friction of a joint",
    equation="F = F_c sign(y'), what is needed where y' = 0",
    source="Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30, 1994",
    laws={"drive": _law_of_joint},
    num_states={},
    needs=("joint of a plant",),
)


@compiled_law
def resisting(dt, speed, force, level):
    """Dry friction of level N beside all other forces on 1 kg, N.

    It stops what it can within a step, and holds it (Karnopp, J. Dyn. Syst.
    Meas. Control 107, 1985).
    """
    return min(max(-speed / dt - force, -level), level)


@plug("drive")
def _law_that_stops(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    for k in range(f.shape[0]):
        f[k] += resisting(dt, l_dot[k], f[k], p[0])


THAT_STOPS = replace(
    CARD,
    form="that stops",
    title="dry friction of a drive",
    equation="F = F_c sign(y'), what is needed where y' = 0",
    source="Karnopp, Computer simulation of stick-slip friction, J. Dyn. Syst."
    " Meas. Control 107, 1985",
    laws={"drive": _law_that_stops},
    num_states={},
    needs=("sum of forces",),
)

CARDS = (CARD, WITHOUT_CREEP, OF_JOINT, THAT_STOPS)
