"""A chest that widens and narrows."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug


@plug("compression")
def _law(t, dt, pad, d, p, x):
    w = 2.0 * math.pi * p[1]
    phase = w * t + p[2]
    d[0] += p[0] * (math.sin(phase) + p[3] * math.sin(2.0 * phase))
    d[1] += p[0] * w * (math.cos(phase) + 2.0 * p[3] * math.cos(2.0 * phase))


CARD = Effect(
    name="breathing",
    block="torso",
    title="breathing",
    equation="d = d_0 + A (sin(w t + p) + h sin(2 (w t + p))) at both pads",
    source="De Groote et al., Chest wall motion during tidal breathing, J."
    " Appl. Physiol. 83, 1997; rates: Fleming et al., Lancet 377, 2011",
    parameters=(
        EffectParameter(
            "amplitude_m", "m", -0.01, 0.01, (3e-4,), "amplitude A"
        ),
        EffectParameter(
            "rate_Hz",
            "Hz",
            0.1,
            0.7,
            (0.15, 0.2, 0.25, 0.3, 0.35, 0.42, 0.5),
            "breaths in a second",
            off=None,
        ),
        EffectParameter(
            "phase_rad", "rad", -8.0, 8.0, (0.0, 1.57), "phase p", off=None
        ),
        EffectParameter(
            "second_harmonic", "1", -1.0, 1.0, (0.1,), "share h", off=None
        ),
    ),
    laws={"compression": _law},
    signature="a slow periodic force, in quiet holds too",
    impostors={"posture_drift": "does not come back"},
    experiment="quiet hold in contact over several breaths",
)
