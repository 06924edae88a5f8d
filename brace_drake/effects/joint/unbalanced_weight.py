"""A weight that turns with a rotary axis."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("drive")
def _law(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: angle)
    # The axis puts the angle that l counts in behind the parameters.
    for k in range(f.shape[0]):
        angle = p[2] * l[k]
        f[k] -= p[0] * math.cos(angle) + p[1] * math.sin(angle)


CARD = Effect(
    name="unbalanced_weight",
    block="mechanism",
    title="a weight that turns with the axis",
    equation="F = a cos y + b sin y, of a weight m g at the arm r: the root of"
    " a^2 + b^2 is m g r",
    source="Craig, Introduction to Robotics, section 6.7",
    parameters=(
        EffectParameter(
            "cosine_N", "N", -60.0, 60.0, (1.0,), "torque a at the angle 0"
        ),
        EffectParameter(
            "sine_N", "N", -60.0, 60.0, (1.0,), "torque b at a right angle"
        ),
    ),
    laws={"drive": _law},
    needs=("one joint", "joint position", "angle"),
    signature="a torque that follows the angle, the same both ways",
    impostors={"stiffening": "a spring's, which has no turn of its own"},
    remedy="balance the weight, or write its mass and arm into the scenario",
    experiment="slow strokes over a wide angle",
)
