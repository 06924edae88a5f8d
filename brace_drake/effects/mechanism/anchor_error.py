"""Anchors of the legs that are not where the controller believes them."""

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter


def _modify(numbers, values: np.ndarray):
    lower, upper = np.reshape(values, (2, 6, 3))
    return numbers.with_changes(
        lower=numbers.lower + lower, upper=numbers.upper + upper
    )


CARD = Effect(
    name="anchor_error",
    block="mechanism",
    title="anchors off their drawn places",
    equation="B_k = B_k nominal + b_k, T_k = T_k nominal + t_k, unknown to the"
    " controller; components of b_k, t_k normal with mean 0 and standard"
    " deviation s",
    source="Merlet, Parallel Robots, chapter 10 (calibration); common spread"
    " of a hierarchical prior, Gelman et al., Bayesian Data Analysis, chapter"
    " 5",
    parameters=tuple(
        EffectParameter(
            f"{ring}{k}_{axis}_m",
            "m",
            -0.02,
            0.02,
            (0.0,),
            f"displacement of {ring} anchor {k} along {axis}",
        )
        for ring in ("lower", "upper")
        for k in range(1, 7)
        for axis in "xyz"
    ),
    modify=_modify,
    spread=("anchor_m", "m"),
    signature="leg lengths off at rest, a pose error that stays, force"
    " directions off in proportion to the leg forces",
    impostors={"encoder_offset": "shifts lengths, leaves force directions"},
    remedy="measure the places of the joints and write them into the scenario",
    experiment="stairs over the whole workspace",
)
