"""Gain of a signal that is off."""

from brace_drake.effects.card import EffectParameter
from brace_drake.effects.signal.ways import signal_cards
from brace_drake.laws.hooks import plug


@plug("signal")
def _law(t, dt, y, p, x):
    y[0] *= 1.0 + p[0]


CARDS = signal_cards(
    "gain",
    "gain",
    _law,
    (
        EffectParameter(
            "gain_error", "1", -0.95, 4.0, (0.1,), "gain g more than nominal"
        ),
    ),
    equation="y = (1 + g) s",
    source="Fraden, Handbook of Modern Sensors, section 3.1",
    signature="in proportion to the signal, whatever its speed",
    impostors={"command_lag": "less at fast motion alone"},
    remedy="compare this channel with a known value and correct its"
    " sensitivity",
    experiment="the same motion at two amplitudes",
    names=("command_gain", "sensor_scale"),
)
