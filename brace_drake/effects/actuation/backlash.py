"""Play between the drive of a leg and the ring."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.kinematics import hold_at_rest
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


@plug("drive")
def _gap_drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741
    # x[k]: place g of the drive in the gap of leg k; x[n]: whether it is known.
    # A run begins with the ring held at rest, each leg at an end of its gap.
    n, half = f.shape[0], 0.5 * p[0]
    if half <= 0.0:
        return
    if x[n] == 0.0:
        x[n] = 1.0
        for k in range(min(n, p.shape[0] - 2)):
            x[k] = math.copysign(half, p[2 + k])
    for k in range(f.shape[0]):
        free = x[k] + dt * (u[k] / law[k] - l_dot[k])
        x[k] = min(max(free, -half), half)
        if law[k] > 0.0:
            # What the end of the gap has to take up in this step.
            passed = law[k] * (free - x[k]) / dt
            f[k] += passed - (u[k] - law[k] * l_dot[k])


@plug("sensing")
def _gap_sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    # x: places in the gap (n), lengths before (n), whether there are any.
    n, half = l.shape[0], 0.5 * p[0]
    for k in range(n):
        if x[2 * n] != 0.0:
            move = l[k] - x[n + k]
            x[k] = min(max(x[k] + h * u[k] / p[1] - move, -half), half)
        elif k < p.shape[0] - 2:
            x[k] = math.copysign(half, p[2 + k])
        x[n + k] = l[k]
        l[k] += x[k]
    x[2 * n] = 1.0


DRIVE_VISCOUS = EffectParameter(
    "drive_viscous_N_s_m",
    "N s/m",
    1.0,
    1000.0,
    (40.0,),
    "viscous friction b of the drive, as on the data sheet",
    off=None,
    choices=(40.0,),
)
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

CARDS = (
    Effect(
        title="play that the encoder reads as lost motion",
        form="play",
        equation="l_read = min(max(l_read before, l - w/2), l + w/2)",
        parameters=(_WIDTH,),
        laws={"sensing": _play},
        needs=("length reading",),
        num_states={"sensing": 7},
        **_COMMON,
    ),
    Effect(
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
    ),
)
