"""The library's effects on a brace of several stages: of one, or of all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache

from brace_drake.effects.card import Effect
from brace_drake.effects.registry import effects_for
from brace_drake.effects.stack import EACH_STAGE
from brace_drake.effects.within_tolerances import (
    ANCHORS,
    NUMBERS,
    WITHIN_TOLERANCES,
)

# An effect of so many parameters has some for each leg, or names a leg: it is
# of one stage.
_OF_LEGS = 6


def stage_cards(device: str, stages: Sequence[int]) -> dict[str, Effect]:
    """Cards by key: what a single stage can have, its number in the key, and
    what all stages or the torso can have.

    Args:
        device: Whose library it is.
        stages: Those that move, by number.
    """
    return dict(_of_stages(device, tuple(stages)))


@cache
def _of_stages(device: str, stages: tuple[int, ...]):
    cards = effects_for(device).values()
    return {e.key: e for card in cards for e in _placed(card, stages)}


def _placed(card: Effect, stages: tuple[int, ...]) -> Iterator[Effect]:
    if not _is_of_legs(card) or len(stages) == 1:
        yield card
    if card.block == "torso" or len(stages) == 1:
        return
    for index in range(len(stages)):
        yield of_stage(card, index, stages)


def of_stage(card: Effect, index: int, stages: Sequence[int]) -> Effect:
    """An effect of one of several stages alone.

    Args:
        card: Of any stage.
        index: Of the stage, from 0.
        stages: Those that move, by number.
    """
    at = f"stage {stages[index]}"
    return replace(
        card,
        at=at,
        title=f"{card.title}: {at}",
        stage=(index, len(stages)),
    )


def stages_within_tolerances(stages: Sequence[int]) -> Effect:
    """All that may be off on stages within tolerances, at once."""
    if len(stages) == 1:
        return WITHIN_TOLERANCES
    names = (*NUMBERS, *ANCHORS.parameter_names)
    own = list(zip(names, WITHIN_TOLERANCES.parameters, strict=True))
    parameters = tuple(
        replace(p, name=f"stage{stage}_{name}")
        for stage in stages
        for name, p in own
    )
    return replace(
        WITHIN_TOLERANCES,
        parameters=parameters,
        stage=(EACH_STAGE, len(stages)),
    )


def _is_of_legs(card: Effect) -> bool:
    names_leg = any(p.choices for p in card.parameters)
    return names_leg or len(card.parameters) >= _OF_LEGS
