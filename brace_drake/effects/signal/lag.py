"""First-order lag of a signal."""

import math

from brace_drake.effects.card import EffectParameter
from brace_drake.effects.signal.ways import signal_cards
from brace_drake.laws.hooks import plug


@plug("signal")
def _law(t, dt, y, p, x):
    # x: the lagging value and the signal before, then whether they are known.
    if x[2] == 0.0:
        x[0], x[1], x[2] = y[0], y[0], 1.0
    if p[0] > 1e-6:
        # Exact where the signal goes straight from one sample to the next.
        stays = math.exp(-dt / p[0])
        behind = p[0] * (y[0] - x[1]) / dt * (1.0 - stays)
        x[0] = y[0] + stays * (x[0] - x[1]) - behind
        x[1] = y[0]
        y[0] = x[0]


CARDS = signal_cards(
    "lag",
    "first-order lag",
    _law,
    (EffectParameter("lag_s", "s", 0.0, 1.0, (0.02, 0.1), "time constant T"),),
    num_states=3,
    equation="T y' = s - y",
    source="Astrom and Murray, Feedback Systems, section 6.3",
    signature="late, and smaller the faster it moves",
    impostors={"command_delay": "late, but as large at any speed"},
    remedy="look for a low-pass filter of this channel; raise its"
    " cut-off frequency, or keep the effect in the twin",
    experiment="a multisine of a wide band",
)
