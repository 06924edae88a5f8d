"""Muscles that answer a push, a little late."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.arrays import pick
from brace_drake.laws.lanes.elementary import floor
from brace_drake.laws.lanes.functions import where

# Past motion is kept in steps of 1 ms, over 0.4 s.
_STEP, _DEPTH = 1e-3, 400


@compiled_law
def _place(step):
    return step - _DEPTH * floor(step / _DEPTH)


@plug("torso", lanes=True)
def _law(t, dt, p_T, r_T, V, law, F, p, x):
    # x: y (_DEPTH), y' (_DEPTH) of the torso, each step at its own place.
    now = math.floor(t / _STEP + 1e-6)
    x[now % _DEPTH] = p_T[1]
    x[_DEPTH + now % _DEPTH] = V[4]
    at = t / _STEP - p[2] / _STEP
    acts = at >= 0.0
    at = max(at, 0.0)
    first = floor(at)
    share = at - first
    i, j = _place(first), _place(first + 1.0)
    y = (1.0 - share) * pick(x, i) + share * pick(x, j)
    v = (1.0 - share) * pick(x, _DEPTH + i) + share * pick(x, _DEPTH + j)
    F[4] = where(acts, F[4] - (p[0] * y + p[1] * v), F[4])


CARD = Effect(
    name="reflex",
    block="torso",
    title="reflexes of the trunk's muscles",
    equation="f_y = -k_r y(t - T) - d_r y'(t - T) on the torso",
    source="Moorhouse and Granata, Role of reflex dynamics in spinal"
    " stability, J. Biomech. 40, 2007",
    parameters=(
        EffectParameter(
            "reflex_stiffness_N_m",
            "N/m",
            0.0,
            20000.0,
            (200.0,),
            "answer k_r to displacement",
        ),
        EffectParameter(
            "reflex_damping_N_s_m",
            "N s/m",
            0.0,
            2000.0,
            (10.0,),
            "answer d_r to velocity",
        ),
        EffectParameter(
            "reflex_delay_s",
            "s",
            0.005,
            0.35,
            (0.06, 0.15),
            "delay T of the answer",
            off=None,
        ),
    ),
    laws={"torso": _law},
    num_states={"torso": 2 * _DEPTH},
    signature="the torso stiffens a tenth of a second after a push",
    impostors={
        "relaxation": "in the contact: force and depth disagree, torso as it is"
    },
    remedy="nothing is wrong with the machine: the subject answers the push;"
    " push slower, or announce it",
    experiment="multisine up to 5 Hz in contact",
)
