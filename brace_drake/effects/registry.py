"""All effects: every module in this folder that holds a CARD, or CARDS."""

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
    """Cards by key (see `Effect.key`), in the order of the files.

    Raises:
        EffectError: Two cards have the same key.
    """
    cards: dict[str, Effect] = {}
    for module in pkgutil.iter_modules(brace_drake.effects.__path__):
        loaded = importlib.import_module(f"brace_drake.effects.{module.name}")
        card = getattr(loaded, "CARD", None)
        forms = getattr(loaded, "CARDS", () if card is None else (card,))
        for form in forms:
            if form.key in cards:
                raise EffectError(f"effect {form.key} is registered twice")
            cards[form.key] = form
    return cards


def effects_for(device: str) -> dict[str, Effect]:
    """Cards of the effects that can occur on a device."""
    return {n: e for n, e in all_effects().items() if device in e.devices}


def find_effect(key: str) -> Effect:
    """The card of a key, or of a name: then its first form.

    Raises:
        EffectError: No such effect; the message offers the closest.
    """
    cards = all_effects()
    for card in cards.values():
        if key in (card.key, card.name):
            return card
    close = difflib.get_close_matches(key, cards, n=1, cutoff=0.0)
    raise EffectError(
        f"no effect {key!r}; did you mean {close[0]!r}? There are"
        f" {', '.join(cards)}"
    )
