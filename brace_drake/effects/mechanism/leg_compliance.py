"""Legs that give way under their own force."""

import math

from brace_drake.effects.actuation.backlash import DRIVE_VISCOUS
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.kinematics import hold_at_rest
from brace_drake.laws.hooks import plug


@plug("drive")
def _drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    # x[k]: stretch e = l_drive - l of the leg's spring; x[n]: whether it is
    # known. A run begins with the ring held at rest.
    n = f.shape[0]
    if p[0] <= 0.0:
        return
    if x[n] == 0.0:
        x[n] = 1.0
        for k in range(min(n, p.shape[0] - 2)):
            x[k] = p[0] * p[2 + k]
    for k in range(f.shape[0]):
        balanced = p[0] * (u[k] - law[k] * l_dot[k])
        rate = dt / max(p[0] * law[k], 1e-12)
        decay = math.exp(-rate)
        # The exact mean over the step keeps a stiff spring stable.
        mean = balanced + (x[k] - balanced) * (1.0 - decay) / rate
        x[k] = balanced + (x[k] - balanced) * decay
        f[k] += mean / p[0] - (u[k] - law[k] * l_dot[k])


@plug("sensing")
def _sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    # x: stretch (n), lengths before (n), whether there are any.
    n = l.shape[0]
    if p[0] <= 0.0:
        return
    decay = math.exp(-h / (p[0] * p[1]))
    for k in range(n):
        if x[2 * n] != 0.0:
            balanced = p[0] * (u[k] - p[1] * (l[k] - x[n + k]) / h)
            x[k] = balanced + (x[k] - balanced) * decay
        elif k < p.shape[0] - 2:
            x[k] = p[0] * p[2 + k]
        x[n + k] = l[k]
        l[k] += x[k]
    x[2 * n] = 1.0


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
    laws={"drive": _drive, "sensing": _sensing},
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
