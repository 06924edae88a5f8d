"""Dead time of a signal."""

import math

from brace_drake.effects.card import EffectParameter
from brace_drake.effects.signal.ways import signal_cards
from brace_drake.laws.hooks import plug

# Past values kept; the longest delay over the shortest step must fit.
DEPTH = 512
LONGEST_S = 0.2


@plug("signal")
def _law(t, dt, y, p, x):
    # x: the last values by step modulo DEPTH, then how many there were.
    step = int(x[DEPTH])
    x[step % DEPTH] = y[0]
    x[DEPTH] = step + 1.0
    steps = min(p[0] / dt, DEPTH - 2.0)
    before = math.floor(steps)
    part = steps - before
    # Before the run the signal was what it began with.
    near = x[max(step - int(before), 0) % DEPTH]
    far = x[max(step - int(before) - 1, 0) % DEPTH]
    y[0] = (1.0 - part) * near + part * far


CARDS = signal_cards(
    "delay",
    "dead time",
    _law,
    (
        EffectParameter(
            "delay_s", "s", 0.0, LONGEST_S, (0.01, 0.04), "dead time T"
        ),
    ),
    num_states=DEPTH + 1,
    equation="y(t) = s(t - T)",
    source="Astrom and Murray, Feedback Systems, section 9",
    signature="the same motion, late by the same time at any speed",
    impostors={"command_lag": "fast motion shrinks as well"},
    remedy="give all channels one clock, and measure the time from a step of"
    " the input to this channel",
    experiment="steps and a fast multisine",
)
