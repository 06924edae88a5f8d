"""Drives that give less at most than their data sheet says."""

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.control.brace_control import LIMIT
from brace_drake.laws.hooks import delivered, plug

_UNLIMITED = 120.0


@plug("drive", lanes=True)
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    for k in range(f.shape[0]):
        arrives = delivered(f, law, l_dot, k)
        f[k] += min(max(arrives, -p[0]), p[0]) - arrives


def _limit_commands(numbers, values: np.ndarray):
    law = numbers.control.copy()
    law[LIMIT] = np.minimum(law[LIMIT], values[0])
    return numbers.with_changes(control=law)


_LIMIT = EffectParameter(
    "force_limit_N",
    "N",
    0.1,
    _UNLIMITED,
    (1.5, 3.0, 5.0, 8.0, 14.0, 30.0),
    "largest force L of a leg",
    off=_UNLIMITED,
)
_COMMON = dict(
    name="saturation",
    block="actuation",
    parameters=(_LIMIT,),
    source="Tao and Kokotovic, Adaptive Control of Systems with Actuator and"
    " Sensor Nonlinearities, 1996, chapter 2",
    signature="nothing at small pushes; at large ones the ring falls behind"
    " while commands grow, or stay at one value",
    impostors={
        "force_gain": "in proportion at every load",
        "hardening": "tissue that yields no more; the legs follow commands",
    },
    remedy="check current limits and supply of the drives; plan motions that"
    " stay below",
    experiment="the largest push that is safe",
)

CARDS = (
    Effect(
        title="force of the drives limited below the data sheet",
        form="drive",
        equation="f = sat(u, +-L) - b l'",
        laws={"drive": _law},
        on_command=True,
        **_COMMON,
    ),
    Effect(
        title="commands limited below the data sheet",
        form="command",
        equation="u = sat(J^-T F, +-L)",
        modify=_limit_commands,
        **_COMMON,
    ),
)
