"""Dead time between a command and the force of the drive."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import delivered, plug
from brace_drake.laws.lanes.arrays import pick
from brace_drake.laws.lanes.elementary import floor
from brace_drake.laws.lanes.functions import where

# Past commands kept, in control periods; the longest delay must fit.
_DEPTH = 64
_PERIOD = 1e-3
_LEGS = 6


@compiled_law
def _kept(tick):
    """Where a tick's commands are kept."""
    return tick - _DEPTH * floor(tick / _DEPTH)


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    # x: what arrived in the last _DEPTH ticks, by tick modulo _DEPTH.
    n = f.shape[0]
    tick = math.floor(t / _PERIOD + 1e-6)
    for k in range(n):
        x[(tick % _DEPTH) * _LEGS + k] = delivered(f, law, l_dot, k)
    # The held command as it was p[0] ago, averaged over this plant step.
    begin = (t - p[0]) / _PERIOD
    end = begin + dt / _PERIOD
    first, last = floor(begin + 1e-6), floor(end - 1e-6)
    weight = where(last > first, (last - begin) / (end - begin), 1.0)
    row, next_row = _LEGS * _kept(first), _LEGS * _kept(last)
    for k in range(n):
        before = where(first >= 0.0, pick(x, row + k), 0.0)
        after = where(last >= 0.0, pick(x, next_row + k), 0.0)
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
    remedy="measure the time from a step of the command to the force; shorten"
    " the bus cycle, or give the controller the dead time",
    experiment="free multisine with high frequencies",
)
