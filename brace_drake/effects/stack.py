"""Effects put together: what the twin's blocks take."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.core.errors import EffectError
from brace_drake.effects.card import Effect
from brace_drake.laws.hooks import MAX_EFFECTS, NO_LAW, PLUG_POINTS
from brace_drake.laws.plug_in import PlugIn

Use = tuple[Effect, np.ndarray]

# In place of a stage's index: an effect of all, each with values of its own.
EACH_STAGE = -1


def stack_effects(uses: Sequence[Use], numbers=None) -> dict[str, PlugIn]:
    """Plug-ins of effects with their parameter vectors, by plug point.

    Those that change commands come first, see `Effect.on_command`.

    Args:
        uses: The effects.
        numbers: Of the twin, for effects that take constants of it; without
            them they begin at ease, see `Effect.constants`.

    Raises:
        EffectError: More effects than the twin carries.
    """
    if len(uses) > MAX_EFFECTS:
        raise EffectError(
            f"the twin carries at most {MAX_EFFECTS} effects, got {len(uses)}"
        )
    uses = sorted(uses, key=lambda use: not use[0].on_command)
    idle = MAX_EFFECTS - len(uses)
    parameters = tuple(
        [_vector(effect, values, numbers) for effect, values in uses]
        + [np.zeros(1)] * idle
    )
    return {
        point: PlugIn(
            point,
            tuple(
                [e.laws.get(point, NO_LAW[point]) for e, _ in uses]
                + [NO_LAW[point]] * idle
            ),
            parameters,
            tuple(
                [np.zeros(max(1, e.num_states.get(point, 0))) for e, _ in uses]
                + [np.zeros(1)] * idle
            ),
        )
        for point in PLUG_POINTS
    }


def behind_joints(
    uses: Sequence[Use],
    card: Effect,
    values: np.ndarray,
    forms: Sequence[Effect],
) -> list[tuple[Use, ...]]:
    """Effects with one more that is part of another form of one of them: what
    sticks behind a joint that gives way does not stick to the ring.

    Args:
        uses: The effects.
        card: The one more, as dry friction.
        values: Its parameters.
        forms: Of all effects.

    Returns:
        A set for each such form; none where no effect has any.
    """
    return [
        (*uses[:i], (form, np.append(mine, values)), *uses[i + 1 :])
        for i, (effect, mine) in enumerate(uses)
        for form in forms
        if form.cause == effect.cause
        and card.name in form.contains
        and card.name not in effect.contains
        and len(form.parameters) == len(mine) + len(values)
    ]


def _vector(effect: Effect, values: np.ndarray, numbers) -> np.ndarray:
    if effect.stage is not None:
        return _of_one_stage(effect, values, numbers)
    if effect.constants is None or numbers is None:
        return np.ascontiguousarray(values, dtype=float)
    constants = effect.constants(numbers)
    rows = np.broadcast_to(values, (len(constants), len(values)))
    vectors = np.hstack([rows, constants])
    return vectors[0] if len(vectors) == 1 else vectors


def _of_one_stage(effect: Effect, values: np.ndarray, numbers) -> np.ndarray:
    """A row for each stage, without the effect in the others."""
    index, count = effect.stage
    if index == EACH_STAGE:
        rows = np.reshape(np.asarray(values, dtype=float), (count, -1))
    else:
        rows = np.tile(np.asarray(effect.off(), dtype=float), (count, 1))
        rows[index] = values
    if effect.constants is not None and numbers is not None:
        rows = np.hstack([rows, effect.constants(numbers)])
    return np.ascontiguousarray(rows)


def modify_numbers(numbers, uses: Sequence[Use]):
    """The twin's numbers as the effects have changed them."""
    for effect, values in uses:
        if effect.modify is None:
            continue
        if effect.stage is None:
            numbers = effect.modify(numbers, values)
            continue
        index, count = effect.stage
        own = {index: values}
        if index == EACH_STAGE:
            own = dict(enumerate(np.reshape(values, (count, -1))))
        for stage, mine in own.items():
            changed = effect.modify(numbers, mine)
            numbers = numbers.with_stage_of(changed, stage)
    return numbers
