"""A force that is periodic in position."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.hooks import plug

# Periods over the travel of the machine of reference, 20 mm: near enough to
# each other that a fit from one of them reaches any between.
_TRAVEL_M, _MOST = 0.02, 40
PITCH = EffectParameter(
    "pitch_m",
    "m",
    2e-4,
    0.05,
    tuple(2.0 * _TRAVEL_M / n for n in range(2, 2 * _MOST + 1)),
    "length L of a period",
    off=None,
)


@compiled_law
def periodic(cosine, sine, pitch, y):
    """a cos(2 pi y / L) + b sin(2 pi y / L), in the unit of a and b."""
    angle = 2.0 * math.pi * y / pitch
    return cosine * math.cos(angle) + sine * math.sin(angle)


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: position)
    for k in range(f.shape[0]):
        f[k] -= periodic(p[0], p[1], p[2], l[k])


CARD = Effect(
    name="cogging",
    block="actuation",
    title="a force that is periodic in position",
    equation="F = a cos(2 pi y / L) + b sin(2 pi y / L)",
    source="Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30, 1994,"
    " section 2.1 (position-dependent friction); cogging of motors, ripple of"
    " screws and gears",
    parameters=(
        EffectParameter(
            "cosine_N", "N", -60.0, 60.0, (0.5,), "part a, even in position"
        ),
        EffectParameter(
            "sine_N", "N", -60.0, 60.0, (0.5,), "part b, odd in position"
        ),
        PITCH,
    ),
    laws={"drive": _law},
    needs=("one joint", "joint position"),
    signature="the same ripple at the same places, both ways",
    impostors={"stiffening": "one swing over the whole travel"},
    remedy="turn the drive slowly and map the force over its place; look for"
    " a bent screw, a worn tooth or magnets",
    experiment="slow strokes over the whole travel, both ways",
)
