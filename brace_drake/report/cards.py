"""Cards of the effects that a reader wants to know more about."""

from __future__ import annotations

from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect


def make_cards(causes: list[dict], verdict: dict) -> list[dict]:
    """Cards of the verdict's effects and of the runner-up; none without gap.

    The runner-up is what the data cannot tell apart from the verdict, else
    the best cause that was searched and does not contain it; what both have in
    common is left out. Where no effect is named it is the best cause, called
    the nearest.
    """
    if not verdict["gap"]:
        return []
    # The winner may hold what is within its tolerance, which is not named.
    chosen = [
        part
        for cause in causes
        if cause["chosen"]
        for part in parts_of(cause["effect"])
        if name_of(part) in verdict["effects"]
    ]
    role = "runner-up" if chosen else "nearest in the library"
    return [
        *(make_card(key, "verdict", verdict) for key in chosen),
        *(make_card(key, role, verdict) for key in _runner_up(causes, verdict)),
    ]


def _runner_up(causes: list[dict], verdict: dict) -> list[str]:
    chosen = verdict["effects"]
    ranked = [cause["effect"] for cause in causes if cause["searched"]]
    for effect in [*verdict["ambiguous_with"], *ranked]:
        parts = parts_of(effect)
        # The verdict with something added to it is no rival of the verdict,
        # nor is another form of it.
        found = {name_of(part) for part in parts}
        if chosen and effect in ranked and set(chosen) <= found:
            continue
        others = [part for part in parts if name_of(part) not in chosen]
        if others:
            return others
    return []


def make_card(key: str, role: str, verdict: dict) -> dict:
    """One effect's card.

    Args:
        key: Name of the effect, with its form where there are several.
        role: What it is to the verdict.
        verdict: Of the diagnosis.
    """
    effect, chosen = find_effect(key), verdict["effects"]
    told = [*chosen, *verdict["ambiguous_with"]]
    rivals = {name_of(part) for other in told for part in parts_of(other)}
    rivals -= {name_of(key), *(chosen if role == "verdict" else ())}
    return {
        "name": key,
        "role": role,
        "effect": effect,
        "parameters": _parameters(effect),
        "rivals": rivals,
    }


def _parameters(effect: Effect) -> list[tuple[str, str]]:
    """Names and meanings; of repeated ones their deviation."""
    if effect.spread is None:
        return [(p.name, p.meaning) for p in effect.parameters]
    first, last = effect.parameters[0], effect.parameters[-1]
    count = len(effect.parameters)
    meaning = f"standard deviation of {count}, {first.name} to {last.name}"
    return [(effect.spread[0], meaning)]


def parts_of(effect: str) -> list[str]:
    """Single effects of a candidate such as viscous_leg+force_scale."""
    return effect.split("+")


def name_of(key: str) -> str:
    """Name of an effect that may be told with its form: backlash (gap)."""
    return key.partition(" (")[0]
