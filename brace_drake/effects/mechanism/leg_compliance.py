"""Legs that give way under their own force."""

from dataclasses import replace

from brace_drake.effects.actuation import loose_drive
from brace_drake.effects.actuation.loose_drive import (
    DRIVE_DRY_FRICTION,
    DRIVE_VISCOUS,
    yield_elastic,
)
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.kinematics import hold_at_rest
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug


@compiled_law
def _drive(dt, u, l_dot, law, f, p, level, at_rest, x):
    # x[k]: stretch e = l_drive - l of the leg's spring; x[n]: whether it is
    # known; x[n + 1 + k]: deflection of the drive's bristles, where there are
    # any. A run begins with the ring held at rest.
    n = f.shape[0]
    if p[0] <= 0.0:
        return
    if x[n] == 0.0:
        x[n] = 1.0
        for k in range(min(n, at_rest.shape[0])):
            x[k] = p[0] * at_rest[k]
    for k in range(n):
        z = x[n + 1 + k] if level > 0.0 else 0.0
        x[k], mean, z = yield_elastic(
            dt, u[k], l_dot[k], law[k], p[0], level, x[k], z
        )
        if level > 0.0:
            x[n + 1 + k] = z
        f[k] += mean / p[0] - (u[k] - law[k] * l_dot[k])


@compiled_law
def _sense(h, u, l, p, level, at_rest, x):  # noqa: E741 (l: leg length)
    # x: stretch (n), lengths before (n), whether there are any, deflections
    # of the bristles (n) where there are any.
    n = l.shape[0]
    if p[0] <= 0.0:
        return
    for k in range(n):
        if x[2 * n] != 0.0:
            z = x[2 * n + 1 + k] if level > 0.0 else 0.0
            rate = (l[k] - x[n + k]) / h
            x[k], _, z = yield_elastic(
                h, u[k], rate, p[1], p[0], level, x[k], z
            )
            if level > 0.0:
                x[2 * n + 1 + k] = z
        elif k < at_rest.shape[0]:
            x[k] = p[0] * at_rest[k]
        x[n + k] = l[k]
        l[k] += x[k]
    x[2 * n] = 1.0


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    _drive(dt, u, l_dot, law, f, p, 0.0, p[2:], x)


@plug("sensing")
def _sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    _sense(h, u, l, p, 0.0, p[2:], x)


@plug("drive")
def _law_sticking(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    _drive(dt, u, l_dot, law, f, p, p[2], p[3:], x)


@plug("sensing")
def _sensing_sticking(t, h, u, l, F, p, x):  # noqa: E741
    _sense(h, u, l, p, p[2], p[3:], x)


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
        DRIVE_VISCOUS,
    ),
    laws={"drive": _law, "sensing": _sensing},
    constants=hold_at_rest,
    num_states={"drive": 7, "sensing": 13},
    signature="the torso moves less than the encoders say, in proportion to"
    " the force",
    impostors={
        "backlash": "lost motion of a constant width",
        "encoder_offset": "constant, whatever the force",
    },
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
    parameters=(*CARD.parameters, DRIVE_DRY_FRICTION),
    laws={"drive": _law_sticking, "sensing": _sensing_sticking},
    num_states={"drive": 13, "sensing": 19},
    dithered=True,
    contains=("coulomb_friction", "stribeck_friction"),
)

CARDS = (CARD, STICKING)
