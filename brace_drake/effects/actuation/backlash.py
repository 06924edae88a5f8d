"""Play between the drive of a leg and the ring."""

from dataclasses import replace

from brace_drake.effects.actuation import loose_drive
from brace_drake.effects.actuation.loose_drive import (
    DRIVE_DRY_FRICTION,
    drives_at_rest,
    run_in_gap,
)
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.functions import lead, where

_EQUATION = (
    "g = l_drive - l in [-w/2, w/2]; between the ends no force is passed and"
    " b l_drive' = u, at an end l_drive' = l' and f = u - b l'; the encoder"
    " reads l_drive"
)


@plug("sensing", lanes=True)
def _play(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    # x[k]: what the encoder read last; x[n]: whether it has read anything.
    n = l.shape[0]
    for k in range(n):
        x[k] = where(x[n] == 0.0, l[k], x[k])
        x[k] = min(max(x[k], l[k] - 0.5 * p[0]), l[k] + 0.5 * p[0])
        l[k] = x[k]
    x[n] = 1.0


@compiled_law
def _begin(half, at_rest, known, x):
    # A run begins with the ring held at rest, each leg at an end of its gap.
    if lead(known) == 0.0:
        for k in range(min(x.shape[0], at_rest.shape[0])):
            x[k] = where(at_rest[k] < 0.0, -half, half)


@compiled_law
def _drive(dt, u, l_dot, law, f, half, level, at_rest, x, z):
    # x[k]: place g of the drive in the gap of leg k; x[n]: whether it is known;
    # z: deflections of its bristles, idle where there are none.
    n = f.shape[0]
    _begin(half, at_rest, x[n], x)
    x[n] = 1.0
    for k in range(n):
        is_loose = where(law[k] > 0.0, half, 0.0) > 0.0
        b = where(is_loose, law[k], 1.0)
        x[k], passed, z[k] = run_in_gap(
            dt, u[k], l_dot[k], b, half, level, x[k], z[k]
        )
        more = passed - (u[k] - law[k] * l_dot[k])
        f[k] = where(is_loose, f[k] + more, f[k])


@compiled_law
def _sense(h, u, l, p, level, own, x, z):  # noqa: E741 (l: leg length)
    # x: places in the gap (n), lengths before (n), whether there are any; z as
    # above; own: of `drives_at_rest`.
    n, half = l.shape[0], 0.5 * p[0]
    _begin(half, own[n:], x[2 * n], x)
    for k in range(n):
        if lead(x[2 * n]) != 0.0:
            rate = (l[k] - x[n + k]) / h
            is_loose = own[k] > 0.0
            x[k], _, z[k] = run_in_gap(
                h,
                u[k],
                rate,
                where(is_loose, own[k], 1.0),
                where(is_loose, half, 0.0),
                level,
                x[k],
                z[k],
            )
        x[n + k] = l[k]
        l[k] += x[k]
    x[2 * n] = 1.0


@plug("drive", lanes=True)
def _gap_drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    _drive(dt, u, l_dot, law, f, 0.5 * p[0], 0.0, p[7:], x, x[7:])


@plug("sensing", lanes=True)
def _gap_sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    _sense(h, u, l, p, 0.0, p[1:], x, x[13:])


@plug("drive", lanes=True)
def _sticking_drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    _drive(dt, u, l_dot, law, f, 0.5 * p[0], p[1], p[8:], x, x[7:])


@plug("sensing", lanes=True)
def _sticking_sensing(t, h, u, l, F, p, x):  # noqa: E741
    _sense(h, u, l, p, p[1], p[2:], x, x[13:])


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
    remedy="measure the lost motion at rest with a dial gauge, of each drive;"
    " tighten or preload joints and screw",
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
    parameters=(_WIDTH,),
    laws={"drive": _gap_drive, "sensing": _gap_sensing},
    constants=drives_at_rest,
    num_states={"drive": 13, "sensing": 19},
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
    contains=("coulomb_friction", "stribeck_friction"),
)

CARDS = (PLAY, GAP, STICKING)
