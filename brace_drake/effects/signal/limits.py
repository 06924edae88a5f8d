"""Limits of a command: of its size, and of how fast it changes."""

from brace_drake.effects.card import EffectParameter
from brace_drake.effects.signal.ways import COMMAND, signal_cards
from brace_drake.laws.hooks import plug

_NONE, _FASTEST = 2.0, 2000.0

_REMEDY = (
    "check the range and the supply of this channel; plan motions"
    " that stay inside"
)


@plug("signal")
def _limit(t, dt, y, p, x):
    y[0] = min(max(y[0], -p[0]), p[0])


@plug("signal")
def _limit_rate(t, dt, y, p, x):
    # x: the value before, then whether there was one.
    if x[1] == 0.0:
        x[0], x[1] = y[0], 1.0
    most = p[0] * dt
    x[0] += min(max(y[0] - x[0], -most), most)
    y[0] = x[0]


CARDS = (
    *signal_cards(
        "saturation",
        "limit",
        _limit,
        (
            EffectParameter(
                "limit",
                "signal",
                0.05,
                _NONE,
                (0.3, 0.6, 0.85),
                "largest size L",
                off=_NONE,
            ),
        ),
        ways=(COMMAND,),
        names=("saturation", ""),
        equation="y = sat(s, +-L)",
        source="Tao and Kokotovic, Adaptive Control of Systems with Actuator"
        " and Sensor Nonlinearities, 1996, chapter 2",
        signature="nothing at small commands, too little at large ones",
        impostors={"command_gain": "in proportion at any size"},
        remedy=_REMEDY,
        experiment="the largest command that is safe",
    ),
    *signal_cards(
        "rate_limit",
        "limit of the rate",
        _limit_rate,
        (
            EffectParameter(
                "rate",
                "signal/s",
                0.05,
                _FASTEST,
                (1.0, 4.0, 16.0),
                "largest rate R",
                off=_FASTEST,
            ),
        ),
        num_states=2,
        ways=(COMMAND,),
        names=("rate_limit", ""),
        equation="|y'| <= R",
        source="Astrom and Murray, Feedback Systems, section 11.4",
        signature="steps become ramps of one slope",
        impostors={"command_lag": "an exponential, in proportion to the step"},
        remedy=_REMEDY,
        experiment="steps of two sizes",
    ),
)
