"""Leg encoders that do not read the true length."""

from dataclasses import replace

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.one_leg import ONE_LEG
from brace_drake.laws.hooks import plug
from brace_drake.laws.lanes.functions import where


@plug("sensing", lanes=True)
def _law(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    for k in range(l.shape[0]):
        l[k] += p[k]


@plug("sensing", lanes=True)
def _law_of_one(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    for k in range(l.shape[0]):
        l[k] = where(p[0] == k + 1.0, l[k] + p[1], l[k])


CARD = Effect(
    name="encoder_offset",
    block="sensing",
    title="constant offsets of the leg lengths",
    equation="l_k,read = l_k + o_k",
    source="Merlet, Parallel Robots, chapter 10 (calibration)",
    parameters=tuple(
        EffectParameter(
            f"offset{k}_m", "m", -0.01, 0.01, (1e-4,), f"offset of leg {k}"
        )
        for k in range(1, 7)
    ),
    laws={"sensing": _law},
    needs=("brace",),
    signature="the ring starts with a jump and holds a wrong pose",
    impostors={
        "anchor_error": "force directions off as well, lengths change with pose"
    },
    remedy="reference the legs again, at a stop or with a gauge",
    experiment="any run: the first second shows it",
)

ONE = replace(
    CARD,
    form="one leg",
    title="constant offset of the length of one leg",
    equation="l_k,read = l_k + o of one leg k",
    parameters=(
        ONE_LEG,
        EffectParameter(
            "offset_m", "m", -0.01, 0.01, (5e-4,), "offset of that leg"
        ),
    ),
    laws={"sensing": _law_of_one},
)

CARDS = (CARD, ONE)
