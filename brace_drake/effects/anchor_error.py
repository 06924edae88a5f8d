"""Anchors of the legs that are not where the controller believes them."""

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter


def _modify(numbers, values: np.ndarray):
    return numbers.with_changes(
        p_RT=numbers.p_RT + np.reshape(values, (6, 3))
    )


def _summary(values: np.ndarray) -> dict[str, float]:
    return {"anchor_rms_m": float(np.sqrt(np.mean(values**2)))}


CARD = Effect(
    name="anchor_error",
    block="mechanism",
    title="anchors off their drawn places",
    equation="p_RT,k = p_RT,k nominal + delta_k, unknown to the controller",
    source="Merlet, Parallel Robots, chapter 10 (calibration)",
    parameters=tuple(
        EffectParameter(
            f"anchor{k}_{axis}_m",
            "m",
            -0.02,
            0.02,
            (0.0005,),
            f"displacement of upper anchor {k} along {axis}",
        )
        for k in range(1, 7)
        for axis in "xyz"
    ),
    modify=_modify,
    summary=_summary,
    signature="leg lengths off at rest, a pose error that stays",
    impostors={"encoder_offset": "shifts lengths, leaves force directions"},
    experiment="stairs over the whole workspace",
)
