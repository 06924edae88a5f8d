"""Legs that give way under their own force."""

from dataclasses import replace

from brace_drake.effects.actuation import loose_drive
from brace_drake.effects.actuation.loose_drive import (
    DRIVE_DRY_FRICTION,
    drives_at_rest,
    yield_elastic,
)
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.functions import lead, some, where


@compiled_law
def _begin(compliance, at_rest, known, x):
    # A run begins with the ring held at rest.
    if lead(known) == 0.0:
        for k in range(min(x.shape[0], at_rest.shape[0])):
            x[k] = compliance * at_rest[k]


@compiled_law
def _drive(dt, u, l_dot, law, f, p, level, at_rest, x, z):
    # x[k]: stretch e = l_drive - l of the leg's spring; x[n]: whether it is
    # known; z: deflections of the drive's bristles, idle where there are none.
    n, yields = f.shape[0], p[0] > 0.0
    if not some(yields):
        return
    compliance = where(yields, p[0], 1.0)
    _begin(compliance, at_rest, x[n], x)
    x[n] = 1.0
    for k in range(n):
        x[k], mean, z[k] = yield_elastic(
            dt, u[k], l_dot[k], law[k], compliance, level, x[k], z[k]
        )
        more = mean / compliance - (u[k] - law[k] * l_dot[k])
        f[k] = where(yields, f[k] + more, f[k])


@compiled_law
def _sense(h, u, l, p, level, own, x, z):  # noqa: E741 (l: leg length)
    # x: stretch (n), lengths before (n), whether there are any; z as above;
    # own: of `drives_at_rest`.
    n, yields = l.shape[0], p[0] > 0.0
    if not some(yields):
        return
    compliance = where(yields, p[0], 1.0)
    _begin(compliance, own[n:], x[2 * n], x)
    for k in range(n):
        if lead(x[2 * n]) != 0.0:
            rate = (l[k] - x[n + k]) / h
            x[k], _, z[k] = yield_elastic(
                h, u[k], rate, own[k], compliance, level, x[k], z[k]
            )
        x[n + k] = l[k]
        l[k] = where(yields, l[k] + x[k], l[k])
    x[2 * n] = 1.0


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    _drive(dt, u, l_dot, law, f, p, 0.0, p[7:], x, x[7:])


@plug("sensing", lanes=True)
def _sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    _sense(h, u, l, p, 0.0, p[1:], x, x[13:])


@plug("drive", lanes=True)
def _law_sticking(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    _drive(dt, u, l_dot, law, f, p, p[1], p[8:], x, x[7:])


@plug("sensing", lanes=True)
def _sensing_sticking(t, h, u, l, F, p, x):  # noqa: E741
    _sense(h, u, l, p, p[1], p[2:], x, x[13:])


CARD = Effect(
    name="leg_compliance",
    block="mechanism",
    title="elastic legs, lengths read on the drive side",
    equation="f = e / C, b l_drive' = u - f, e = l_drive - l; the encoder"
    " reads l_drive",
    source="Spong, Modeling and control of elastic joint robots, J. Dyn. Syst."
    " Meas. Control 109, 1987",
    parameters=(
        EffectParameter(
            "compliance_m_N", "m/N", 0.0, 1e-3, (1e-5,), "compliance C of a leg"
        ),
    ),
    laws={"drive": _law, "sensing": _sensing},
    constants=drives_at_rest,
    num_states={"drive": 13, "sensing": 19},
    signature="the torso moves less than the encoders say, in proportion to"
    " the force",
    impostors={
        "backlash": "lost motion of a constant width",
        "encoder_offset": "constant, whatever the force",
    },
    remedy="load a leg against a stop and read how far it gives way beside"
    " its encoder; stiffen its joints and shaft",
    experiment="stairs; the marker shows what the encoders miss",
)

# Where drives stick the spring is between what sticks and the ring.
STICKING = replace(
    CARD,
    form=loose_drive.STICKING,
    title="elastic legs behind drives that stick, lengths read on the drive"
    " side",
    equation="f = e / C, b l_drive' = u - f - F_c(l_drive'), e = l_drive - l;"
    " the encoder reads l_drive",
    source=f"{CARD.source}; {loose_drive.SOURCE}",
    parameters=(
        # What either strength does hides the other: no way leads from a stiff
        # leg to a soft one.
        replace(CARD.parameters[0], starts=(1e-5, 1e-4)),
        DRIVE_DRY_FRICTION,
    ),
    laws={"drive": _law_sticking, "sensing": _sensing_sticking},
    dithered=True,
    contains=("coulomb_friction", "stribeck_friction"),
)

CARDS = (CARD, STICKING)
