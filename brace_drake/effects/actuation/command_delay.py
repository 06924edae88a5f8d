"""Dead time between a command and the force of the drive."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import delivered, plug

# Past commands kept, in control periods; the longest delay must fit.
_DEPTH = 64
_PERIOD = 1e-3
_LEGS = 6


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    # x: what arrived in the last _DEPTH ticks, by tick modulo _DEPTH.
    n = f.shape[0]
    tick = math.floor(t / _PERIOD + 1e-6)
    for k in range(n):
        x[(tick % _DEPTH) * _LEGS + k] = delivered(f, law, l_dot, k)
    # The held command as it was p[0] ago, averaged over this plant step.
    begin = (t - p[0]) / _PERIOD
    end = begin + dt / _PERIOD
    first = math.floor(begin + 1e-6)
    last = math.floor(end - 1e-6)
    weight = 1.0
    if last > first:
        weight = (last - begin) / (end - begin)
    for k in range(n):
        before = x[(first % _DEPTH) * _LEGS + k] if first >= 0 else 0.0
        after = x[(last % _DEPTH) * _LEGS + k] if last >= 0 else 0.0
        late = weight * before + (1.0 - weight) * after
        f[k] += late - delivered(f, law, l_dot, k)


CARD = Effect(
    name="command_delay",
    block="actuation",
    title="dead time between command and force",
    equation="f(t) = u(t - T) - b l', u = 0 before the run",
    source="Astrom and Murray, Feedback Systems, section 9",
    parameters=(
        EffectParameter(
            "delay_s", "s", 0.0, 0.05, (0.002, 0.006, 0.012), "dead time T"
        ),
    ),
    laws={"drive": _law},
    on_command=True,
    num_states={"drive": _DEPTH * _LEGS},
    signature="start-up dip while the first commands travel; ringing of the"
    " position loop",
    impostors={
        "viscous_leg": "a phase lag as well, but no dead time at the start",
        "force_lag": "acts through the impedance filter only",
    },
    experiment="free multisine with high frequencies",
)
