"""A position behind a transmission that is periodic in position."""

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.joint.cogging import PITCH, periodic
from brace_drake.laws.hooks import plug


@plug("sensing")
def _law(t, h, u, l, F, p, x):  # noqa: E741 (l: position)
    for k in range(l.shape[0]):
        l[k] += periodic(p[0], p[1], p[2], l[k])


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
        PITCH,
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
