"""Play between the drive of a leg and the ring."""

import math
from dataclasses import replace

from brace_drake.effects.actuation import loose_drive
from brace_drake.effects.actuation.loose_drive import (
    DRIVE_DRY_FRICTION,
    DRIVE_VISCOUS,
    run_in_gap,
)
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.kinematics import hold_at_rest
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug

_EQUATION = (
    "g = l_drive - l in [-w/2, w/2]; between the ends no force is passed and"
    " b l_drive' = u, at an end l_drive' = l' and f = u - b l'; the encoder"
    " reads l_drive"
)


@plug("sensing")
def _play(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    # x[k]: what the encoder read last; x[n]: whether it has read anything.
    n = l.shape[0]
    for k in range(n):
        if x[n] == 0.0:
            x[k] = l[k]
        x[k] = min(max(x[k], l[k] - 0.5 * p[0]), l[k] + 0.5 * p[0])
        l[k] = x[k]
    x[n] = 1.0


@compiled_law
def _drive(dt, u, l_dot, law, f, half, level, at_rest, x):
    # x[k]: place g of the drive in the gap of leg k; x[n]: whether it is known;
    # x[n + 1 + k]: deflection of its bristles, where there are any. A run
    # begins with the ring held at rest, each leg at an end of its gap.
    n = f.shape[0]
    if half <= 0.0:
        return
    if x[n] == 0.0:
        x[n] = 1.0
        for k in range(min(n, at_rest.shape[0])):
            x[k] = math.copysign(half, at_rest[k])
    for k in range(n):
        if law[k] <= 0.0:
            continue
        z = x[n + 1 + k] if level > 0.0 else 0.0
        x[k], passed, z = run_in_gap(
            dt, u[k], l_dot[k], law[k], half, level, x[k], z
        )
        if level > 0.0:
            x[n + 1 + k] = z
        f[k] += passed - (u[k] - law[k] * l_dot[k])


@compiled_law
def _sense(h, u, l, p, level, at_rest, x):  # noqa: E741 (l: leg length)
    # x: places in the gap (n), lengths before (n), whether there are any,
    # deflections of the bristles (n) where there are any.
    n, half = l.shape[0], 0.5 * p[0]
    for k in range(n):
        if x[2 * n] != 0.0:
            z = x[2 * n + 1 + k] if level > 0.0 else 0.0
            rate = (l[k] - x[n + k]) / h
            x[k], _, z = run_in_gap(h, u[k], rate, p[1], half, level, x[k], z)
            if level > 0.0:
                x[2 * n + 1 + k] = z
        elif k < at_rest.shape[0]:
            x[k] = math.copysign(half, at_rest[k])
        x[n + k] = l[k]
        l[k] += x[k]
    x[2 * n] = 1.0


@plug("drive")
def _gap_drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    _drive(dt, u, l_dot, law, f, 0.5 * p[0], 0.0, p[2:], x)


@plug("sensing")
def _gap_sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    _sense(h, u, l, p, 0.0, p[2:], x)


@plug("drive")
def _sticking_drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    _drive(dt, u, l_dot, law, f, 0.5 * p[0], p[2], p[3:], x)


@plug("sensing")
def _sticking_sensing(t, h, u, l, F, p, x):  # noqa: E741
    _sense(h, u, l, p, p[2], p[3:], x)


_WIDTH = EffectParameter(
    "backlash_m", "m", 0.0, 0.005, (2e-4, 8e-4), "width w of the play"
)
_COMMON = dict(
    name="backlash",
    block="actuation",
    dithered=True,
    source="Nordin and Gutman, Controlling mechanical systems with backlash,"
    " a survey, Automatica 38, 2002",
    signature="encoders and ring part by a constant width at reversals,"
    " whatever the speed and the load",
    impostors={
        "coulomb_friction": "a force step, no lost motion in the marker",
        "leg_compliance": "lost motion in proportion to the force",
    },
    experiment="slow reversals in contact; the marker shows the lost motion",
)

PLAY = Effect(
    title="play that the encoder reads as lost motion",
    form="play",
    equation="l_read = min(max(l_read before, l - w/2), l + w/2)",
    parameters=(_WIDTH,),
    laws={"sensing": _play},
    needs=("length reading",),
    num_states={"sensing": 7},
    **_COMMON,
)
GAP = Effect(
    title="play in which the drive runs free",
    form="gap",
    equation=_EQUATION,
    parameters=(
        _WIDTH,
        DRIVE_VISCOUS,
    ),
    laws={"drive": _gap_drive, "sensing": _gap_sensing},
    constants=hold_at_rest,
    num_states={"drive": 7, "sensing": 13},
    **_COMMON,
)
STICKING = replace(
    GAP,
    title="play in which the drive runs free, or sticks",
    form=f"gap, {loose_drive.STICKING}",
    equation=f"{_EQUATION}; F_c(l_drive') is taken off u",
    source=f"{GAP.source}; {loose_drive.SOURCE}",
    parameters=(*GAP.parameters, DRIVE_DRY_FRICTION),
    laws={"drive": _sticking_drive, "sensing": _sticking_sensing},
    num_states={"drive": 13, "sensing": 19},
    contains=("coulomb_friction", "stribeck_friction"),
)

CARDS = (PLAY, GAP, STICKING)
