"""The library of effects: one module and one card for each, by block.

A card says what an effect is (law, source, parameters with limits), where it
plugs in, what it looks like and what it is taken for. A new effect is one
module with a CARD in the folder of its block; `registry` finds it, and those
that other packages add. `stack` puts effects together for a twin.
"""

from brace_drake.effects.card import BLOCKS, Effect, EffectParameter
from brace_drake.effects.registry import (
    all_effects,
    choice_words,
    effects_for,
    find_effect,
    forget_effect,
    register_effect,
)

__all__ = [
    "BLOCKS",
    "Effect",
    "EffectParameter",
    "all_effects",
    "choice_words",
    "effects_for",
    "find_effect",
    "forget_effect",
    "register_effect",
]
