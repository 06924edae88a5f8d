"""All effects: the library of this folder, and those that others add.

The library is every module in this folder that holds a CARD, or CARDS. From
outside, `register_effect` adds a card to this process, and an installed
package adds its own by entry points of the group `brace_drake.effects`, each
a card; the command line then knows them too.
"""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

import brace_drake.effects
from brace_drake.core.errors import EffectError, suggest
from brace_drake.core.plugins import load_plugins
from brace_drake.effects.card import Effect
from brace_drake.laws.hooks import STAGE_POINTS

# What a bench has, and a brace.
_OF_STAGES = {
    *STAGE_POINTS,
    "brace",
    "command",
    "force reading",
    "length reading",
    "drive of its own",
}
# What each device has that an effect may need: plug points of its rollout,
# what is read at `sensing`, and the numbers and six legs of a brace.
PLACES = {
    "bench stage 2": _OF_STAGES,
    "brace": _OF_STAGES,
    "leg bench": {
        "one drive",
        "drive of its own",
        "drive",
        "sensing",
        "length reading",
        "command",
        "one joint",
        "joint position",
    },
    "pad bench": {"compression", "contact", "sensing", "force reading"},
    "axis under command": {
        "sum of forces",
        "presliding",
        "drive",
        "sensing",
        "length reading",
        "commanded motion",
        "one joint",
        "joint position",
        "angle",
        "signal",
        "command of a port",
    },
    "axis behind a motor": {
        "drive of its own",
        "drive",
        "sensing",
        "length reading",
        "one joint",
        "joint position",
        "angle",
        "signal",
        "reading of a port",
        "two encoders",
    },
    "axis": {
        "one drive",
        "drive of its own",
        "drive",
        "sensing",
        "force reading",
        "one joint",
        "joint position",
        "extra input",
        "imposed motion",
        "presliding",
        "angle",
    },
    "joint of a plant": {
        "drive",
        "one joint",
        "joint position",
        "joint of a plant",
        "angle",
    },
    "joint that is moved": {
        "imposed motion",
        "presliding",
        "drive",
        "drive of its own",
        "one joint",
        "joint position",
        "joint of a plant",
        "angle",
    },
    "command of a port": {"signal", "command of a port"},
    "reading of a port": {"signal", "reading of a port"},
}

# Places of which a device has several, each with a form of an effect.
_HAS_FORMS = {"extra input", "signal", "joint of a plant", "body of a plant"}
ENTRY_POINTS = "brace_drake.effects"

_registered: dict[str, Effect] = {}


def all_effects() -> dict[str, Effect]:
    """Cards by key (see `Effect.key`): the library's, then those added.

    Raises:
        EffectError: Two cards have the same key.
    """
    return {**_library(), **_registered}


def register_effect(card: Effect) -> Effect:
    """Adds an effect to all that this process does from now on.

    Returns:
        The card.

    Raises:
        EffectError: There is an effect with this key already.
    """
    if card.key in all_effects():
        raise EffectError(f"effect {card.key} is registered twice")
    _registered[card.key] = card
    return card


def forget_effect(key: str) -> None:
    """Takes back what `register_effect` has added.

    Raises:
        EffectError: No effect with this key was added.
    """
    if key not in _registered:
        raise EffectError(f"effect {key} was not added by register_effect")
    del _registered[key]


@cache
def _library() -> dict[str, Effect]:
    """The cards of this folder, then those of installed packages."""
    found: list[Effect] = []
    for module in pkgutil.walk_packages(
        brace_drake.effects.__path__, "brace_drake.effects."
    ):
        loaded = importlib.import_module(module.name)
        card = getattr(loaded, "CARD", None)
        found += getattr(loaded, "CARDS", () if card is None else (card,))
    found += load_plugins(ENTRY_POINTS, Effect, "effect", EffectError)
    cards: dict[str, Effect] = {}
    for card in found:
        if card.key in cards:
            raise EffectError(f"effect {card.key} is registered twice")
        cards[card.key] = card
    return cards


def effects_for(device: str) -> dict[str, Effect]:
    """Cards of the effects that can occur on a device: those whose places it
    has.
    """
    known = PLACES.get(device, frozenset())
    return {n: e for n, e in all_effects().items() if e.places <= known}


def find_effect(key: str) -> Effect:
    """The card of a key, or of a name: then its first form. A device may have
    forms of its own, as for each of its inputs, ports, joints or bodies: they
    have the card they are of.

    Raises:
        EffectError: No such effect; the message offers the closest.
    """
    cards = all_effects()
    for card in cards.values():
        if key in (card.key, card.name):
            return card
    name, own_form, _ = key.partition(" (")
    forms = [c for c in cards.values() if own_form and c.name == name]
    for card in sorted(forms, key=lambda c: c.places.isdisjoint(_HAS_FORMS)):
        return card
    hint = suggest(key, cards)
    there = " There" if hint else "; there"
    raise EffectError(f"no effect {key!r}{hint}{there} are {', '.join(cards)}")


def choice_words(name: str, value: float) -> str | None:
    """A parameter's choice in words, None where its number says it."""
    for card in all_effects().values():
        for parameter in card.parameters:
            known = zip(parameter.choices, parameter.words, strict=False)
            if parameter.name == name and value in parameter.choices:
                return dict(known).get(value)
    return None
