"""All effects: every module in this folder that holds a CARD."""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from functools import cache

import brace_drake.effects
from brace_drake.effects.card import Effect
from brace_drake.errors import EffectError


@cache
def all_effects() -> dict[str, Effect]:
    """Cards by name, in the order of the files.

    Raises:
        EffectError: Two files hold the same name.
    """
    cards: dict[str, Effect] = {}
    for module in pkgutil.iter_modules(brace_drake.effects.__path__):
        loaded = importlib.import_module(f"brace_drake.effects.{module.name}")
        card = getattr(loaded, "CARD", None)
        if card is None:
            continue
        if card.name in cards:
            raise EffectError(f"effect {card.name} is registered twice")
        cards[card.name] = card
    return cards


def effects_for(device: str) -> dict[str, Effect]:
    """Cards of the effects that can occur on a device."""
    return {n: e for n, e in all_effects().items() if device in e.devices}


def find_effect(name: str) -> Effect:
    """The card of a name.

    Raises:
        EffectError: No such effect; the message offers the closest.
    """
    cards = all_effects()
    if name not in cards:
        close = difflib.get_close_matches(name, cards, n=1, cutoff=0.0)
        raise EffectError(
            f"no effect {name!r}; did you mean {close[0]!r}? There are"
            f" {', '.join(cards)}"
        )
    return cards[name]
