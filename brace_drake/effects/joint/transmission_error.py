"""A position behind a transmission that is periodic in position."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.joint.cogging import PITCHES
from brace_drake.laws.hooks import plug


@plug("sensing")
def _law(t, h, u, l, F, p, x):  # noqa: E741 (l: position)
    for k in range(l.shape[0]):
        angle = 2.0 * math.pi * l[k] / p[2]
        l[k] += p[0] * math.cos(angle) + p[1] * math.sin(angle)


CARD = Effect(
    name="transmission_error",
    block="actuation",
    title="a transmission error that is periodic in position",
    equation="y_read = y + a cos(2 pi y / L) + b sin(2 pi y / L), y the load's",
    source="Tuttle, Seering, A nonlinear model of a harmonic drive gear"
    " transmission, IEEE Trans. Robotics and Automation 12, 1996 (kinematic"
    " error); runout of gears, encoders and screws",
    parameters=(
        EffectParameter("cosine_m", "m", -0.002, 0.002, (5e-5,), "part a"),
        EffectParameter("sine_m", "m", -0.002, 0.002, (5e-5,), "part b"),
        EffectParameter(
            "pitch_m",
            "m",
            2e-4,
            0.05,
            PITCHES,
            "length L of a period",
            off=None,
        ),
    ),
    laws={"sensing": _law},
    needs=("two encoders",),
    signature="the same difference at the same places, both ways, at any speed",
    impostors={
        "backlash": "the difference goes by the direction, not the place"
    },
    remedy="turn the axis slowly and map the difference of both encoders over"
    " the place; center the encoder or the gear",
    experiment="slow strokes over the whole travel, both ways",
)
