"""A machine that moves no faster than it is allowed to."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    for k in range(f.shape[0]):
        fastest = (p[0] - l_dot[k]) / dt
        slowest = (-p[0] - l_dot[k]) / dt
        f[k] = min(max(f[k], slowest), fastest)


CARD = Effect(
    name="speed_limit",
    block="actuation",
    title="a limit of speed",
    equation="|y'| <= v",
    source="Biagiotti and Melchiorri, Trajectory Planning for Automatic"
    " Machines and Robots, 2008, section 3.2",
    parameters=(
        EffectParameter(
            "speed_m_s",
            "m/s",
            1e-5,
            10.0,
            (0.003, 0.01, 0.03, 0.1),
            "largest speed v",
            off=10.0,
        ),
    ),
    laws={"drive": _law},
    needs=("commanded motion",),
    signature="a ramp of one slope where the command asks for more",
    impostors={"acceleration_limit": "the speed itself bends, at any size"},
    remedy="look up the speed limit of the servo drive; raise it, or plan"
    " below it",
    experiment="fast strokes of two lengths",
)
