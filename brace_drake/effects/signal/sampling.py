"""A signal that is written too coarsely, or too seldom."""

import math

from brace_drake.effects.card import EffectParameter
from brace_drake.effects.signal.ways import signal_cards
from brace_drake.laws.hooks import plug

_REMEDY = (
    "read this channel more often, or let the twin hold it as the machine does"
)
# Periods of 50, 30, 20 and 10 Hz: from others steps of the signal give no way.
_USUAL_S = (0.02, 1.0 / 30.0, 0.05, 0.1)


@plug("signal")
def _round(t, dt, y, p, x):
    if p[0] > 1e-12:
        y[0] = p[0] * math.floor(y[0] / p[0] + 0.5)


@plug("signal")
def _hold(t, dt, y, p, x):
    # x: the value that is held, and until when.
    if t + 1e-9 >= x[1]:
        x[0] = y[0]
        x[1] = max(x[1] + p[0], t)
    y[0] = x[0]


CARDS = (
    *signal_cards(
        "quantisation",
        "coarse steps",
        _round,
        (
            EffectParameter(
                "step", "signal", 0.0, 1.0, (0.05, 0.2), "smallest step q"
            ),
        ),
        equation="y = q round(s / q)",
        source="Widrow and Kollar, Quantization Noise, 2008, chapter 1",
        signature="flat pieces where the signal is slow",
        impostors={"sensor_hold": "flat pieces of one length, also where fast"},
        remedy=_REMEDY,
        experiment="a slow stroke",
    ),
    *signal_cards(
        "hold",
        "seldom updates",
        _hold,
        (
            EffectParameter(
                "period_s", "s", 0.0, 0.5, _USUAL_S, "period T of updates"
            ),
        ),
        num_states=2,
        equation="y(t) = s(T floor(t / T)), as where most samples are dropped",
        source="Astrom and Wittenmark, Computer-Controlled Systems, chapter 2",
        signature="flat pieces of one length, most where it is fast",
        impostors={"command_delay": "late by half a period, without steps"},
        remedy=_REMEDY,
        experiment="a fast multisine",
    ),
)
