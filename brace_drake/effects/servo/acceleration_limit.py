"""A machine that changes its speed no faster than it is allowed to."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    for k in range(f.shape[0]):
        f[k] = min(max(f[k], -p[0]), p[0])


CARD = Effect(
    name="acceleration_limit",
    block="actuation",
    title="a limit of acceleration",
    equation="|y''| <= a",
    source="Biagiotti and Melchiorri, Trajectory Planning for Automatic"
    " Machines and Robots, 2008, section 3.2",
    parameters=(
        EffectParameter(
            "acceleration_m_s2",
            "m/s^2",
            1e-3,
            1e3,
            (0.02, 0.1, 0.5, 2.0, 8.0),
            "largest acceleration a",
            off=1e3,
        ),
    ),
    laws={"drive": _law},
    needs=("commanded motion",),
    signature="speed changes along straight lines, whatever the command's step",
    impostors={
        "command_delay": "late by the same time at any size of the step"
    },
    remedy="look up the acceleration limit of the servo drive; raise it, or"
    " plan below it",
    experiment="steps of the command of two sizes",
)
