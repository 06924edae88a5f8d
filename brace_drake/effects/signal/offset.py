"""Constant offset of a signal."""

from brace_drake.effects.card import EffectParameter
from brace_drake.effects.signal.ways import signal_cards
from brace_drake.laws.hooks import plug


@plug("signal")
def _law(t, dt, y, p, x):
    y[0] += p[0]


CARDS = signal_cards(
    "offset",
    "constant offset",
    _law,
    (EffectParameter("offset", "signal", -2.0, 2.0, (0.05,), "what is added"),),
    equation="y = s + o",
    source="Fraden, Handbook of Modern Sensors, section 3.2",
    signature="there at rest as well",
    impostors={"command_gain": "nothing where the signal is 0"},
    remedy="zero this channel at rest before each run",
    experiment="any run: its first second shows it",
)
