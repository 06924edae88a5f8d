"""Cards of the effects that a reader wants to know more about."""

from __future__ import annotations

from brace_drake.core.errors import EffectError
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect
from brace_drake.report.access import names, rows, text
from brace_drake.report.tables import is_chosen, name_of, parts_of


def make_cards(diagnosis: dict, verdict: dict) -> list[dict]:
    """Cards of the verdict's effects and of the runner-up; none without gap.

    The runner-up is what the data cannot tell apart from the verdict, else
    the best cause that does not contain it; what both have in common is left
    out. Without a verdict from the library it is the best cause, called the
    nearest.
    """
    if not verdict.get("gap"):
        return []
    chosen = names(verdict, "effects")
    cards = [
        make_card(key, "verdict", verdict)
        for key in _chosen_forms(diagnosis, verdict) or chosen
    ]
    role = "runner-up" if chosen else "nearest in the library"
    others = _runner_up(diagnosis, verdict, chosen)
    return cards + [make_card(key, role, verdict) for key in others]


def _chosen_forms(diagnosis: dict, verdict: dict) -> list[str]:
    """The verdict's effects, each with its form."""
    for cause in rows(diagnosis, "causes"):
        if is_chosen(cause, verdict):
            return parts_of(text(cause, "effect"))
    return []


def _runner_up(diagnosis: dict, verdict: dict, chosen: list[str]) -> list[str]:
    ranked = [text(cause, "effect") for cause in rows(diagnosis, "causes")]
    for effect in [*names(verdict, "ambiguous_with"), *ranked]:
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
    """One effect's card; only its name where the library lacks it.

    Args:
        key: Name of the effect, with its form where there are several.
        role: What it is to the verdict.
        verdict: Of the diagnosis.
    """
    name = name_of(key)
    card = {"name": key, "role": role, "known": True}
    try:
        effect = find_effect(key)
    except EffectError:
        return card | {"known": False}
    told = [*names(verdict, "effects"), *names(verdict, "ambiguous_with")]
    rivals = {name_of(part) for other in told for part in parts_of(other)}
    rivals -= {name, *(names(verdict, "effects") if role == "verdict" else ())}
    return card | {
        "title": effect.title,
        "block": effect.block,
        "equation": effect.equation,
        "source": effect.source,
        "signature": effect.signature,
        "experiment": effect.experiment,
        "parameters": _parameters(effect),
        "impostors": [
            {"name": other, "tell": tell, "rival": other in rivals}
            for other, tell in effect.impostors.items()
        ],
    }


def has_run_parameters(verdict: dict) -> bool:
    """Whether one of the verdict's effects has numbers of each single run."""
    for name in names(verdict, "effects"):
        try:
            if find_effect(name).run_parameters:
                return True
        except EffectError:
            continue
    return False


def _parameters(effect: Effect) -> list[tuple[str, str]]:
    """Names and meanings; of many that are drawn alike their deviation."""
    if effect.spread is None:
        return [(p.name, p.meaning) for p in effect.parameters]
    first, last = effect.parameters[0], effect.parameters[-1]
    count = len(effect.parameters)
    meaning = f"standard deviation of {count}, {first.name} to {last.name}"
    return [(effect.spread[0], meaning)]
