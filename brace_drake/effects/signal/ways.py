"""A signal's error as two effects: of a command, and of a reading."""

from __future__ import annotations

from collections.abc import Callable

from brace_drake.effects.card import Effect, EffectParameter

# What a diagram's signals have, see `effects.registry.PLACES`.
COMMAND, READING = "command of a port", "reading of a port"


def signal_cards(
    name: str,
    title: str,
    law: Callable,
    parameters: tuple[EffectParameter, ...],
    num_states: int = 0,
    ways: tuple[str, ...] = (COMMAND, READING),
    names: tuple[str, str] | None = None,
    **words,
) -> tuple[Effect, ...]:
    """Cards of an error that either kind of signal can have.

    Args:
        name: Last part of both names.
        title: In words, without the signal.
        law: At the plug point `signal`.
        parameters: Of the law; values are counted in half of the range that
            the signal goes through, the unit `signal`.
        num_states: Of the law.
        ways: Which of both there are.
        names: Other names of the two effects than command_... and sensor_...
        words: What both cards share.
    """
    both = names or (f"command_{name}", f"sensor_{name}")
    found = []
    for way, own in zip((COMMAND, READING), both, strict=True):
        if way not in ways:
            continue
        is_command = way == COMMAND
        found.append(
            Effect(
                name=own,
                form="signal",
                block="actuation" if is_command else "sensing",
                title=f"{title} of a {'command' if is_command else 'reading'}",
                laws={"signal": law},
                num_states={"signal": num_states},
                parameters=parameters,
                needs=(way,),
                on_command=False,
                **words,
            )
        )
    return tuple(found)
