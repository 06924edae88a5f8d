"""A chest that widens and narrows."""

import math

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.elementary import cos, sin

# A breath's rate and depth change from knot to knot, this far apart.
_SEGMENT = 3.0  # s
_SEGMENTS = 5
_TURN = 2.0 * math.pi


@plug("compression", lanes=True)
def _law(t, dt, pad, d, p, x):
    # p: A (2), rate, h; then phase, rate changes, depth changes of the run.
    phase, speed = p[4] + _TURN * p[2] * t, 1.0
    for k in range(_SEGMENTS):
        inside = min(max(t - k * _SEGMENT, 0.0), _SEGMENT)
        phase += _TURN * p[2] * p[5 + k] * inside
        if k * _SEGMENT <= t < (k + 1) * _SEGMENT:
            speed += p[5 + k]
    at = min(t / _SEGMENT, _SEGMENTS - 1e-9)
    k = int(at)
    first = p[10 + k]
    depth = 1.0 + first + (at - k) * (p[11 + k] - first)
    w = _TURN * p[2] * speed
    sine, cosine = sin(phase), cos(phase)
    twice = 2.0 * (cosine * cosine - sine * sine)
    d[0] += p[pad] * depth * sine * (1.0 + 2.0 * p[3] * cosine)
    d[1] += p[pad] * depth * w * (cosine + p[3] * twice)


def _side(name: str, start: float) -> EffectParameter:
    return EffectParameter(
        f"amplitude_{name}_m",
        "m",
        -0.01,
        0.01,
        (start,),
        f"amplitude A at the pad on the {name}",
    )


CARD = Effect(
    name="breathing",
    block="torso",
    title="breathing",
    equation="d = d_0 + A a(t) (sin p + h sin 2p), p' = 2 pi f (1 + e(t)); A of"
    " its own at either pad; phase, e and a of its own in every run",
    source="De Groote et al., Chest wall motion during tidal breathing, J."
    " Appl. Physiol. 83, 1997; rates: Fleming et al., Lancet 377, 2011",
    parameters=(
        # Both alike would hardly move the brace.
        _side("left", 3e-4),
        _side("right", 1e-4),
        EffectParameter(
            "rate_Hz",
            "Hz",
            0.1,
            0.7,
            (0.17, 0.21, 0.26, 0.32, 0.39, 0.47),
            "breaths in a second f",
            off=None,
        ),
        EffectParameter(
            "second_harmonic", "1", -1.0, 1.0, (0.1,), "share h", off=None
        ),
    ),
    run_parameters=(
        EffectParameter(
            "phase_rad",
            "rad",
            -15.0,
            15.0,
            (0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi),
            "phase at the start",
            off=None,
        ),
        *(
            EffectParameter(
                f"rate_change{k}",
                "1",
                -0.5,
                0.5,
                (0.0,),
                f"relative change of the rate in part {k}",
                off=None,
                deviation=0.1,
            )
            for k in range(1, _SEGMENTS + 1)
        ),
        *(
            EffectParameter(
                f"depth_change{k}",
                "1",
                -0.8,
                0.8,
                (0.0,),
                f"relative change of the depth at knot {k}",
                off=None,
                deviation=0.2,
            )
            for k in range(_SEGMENTS + 1)
        ),
    ),
    laws={"compression": _law},
    needs=("torso",),
    signature="a slow periodic force, in quiet holds too",
    impostors={"posture_drift": "does not come back"},
    remedy="nothing is wrong with the machine: record the breath beside the"
    " runs, ask for even breath, and keep the law in the twin",
    experiment="quiet hold in contact over several breaths",
)
