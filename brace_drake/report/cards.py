"""Cards of the effects that a reader wants to know more about."""

from __future__ import annotations

from brace_drake.effects.registry import all_effects
from brace_drake.report.access import names, rows, text
from brace_drake.report.tables import parts_of


def make_cards(diagnosis: dict, verdict: dict) -> list[dict]:
    """Cards of the verdict's effects and of the runner-up; none without gap.

    The runner-up is what the data cannot tell apart from the verdict, else
    the best cause that shares no effect with it. Without a verdict from the
    library it is the best cause, called the nearest.
    """
    if not verdict.get("gap"):
        return []
    chosen = names(verdict, "effects")
    cards = [make_card(name, "verdict", verdict) for name in chosen]
    runner_up = _runner_up(diagnosis, verdict, chosen)
    role = "runner-up" if chosen else "nearest in the library"
    return cards + [make_card(n, role, verdict) for n in parts_of(runner_up)]


def _runner_up(diagnosis: dict, verdict: dict, chosen: list[str]) -> str:
    ambiguous = names(verdict, "ambiguous_with")
    ranked = [text(cause, "effect") for cause in rows(diagnosis, "causes")]
    for effect in [*ambiguous, *ranked]:
        if effect and not set(parts_of(effect)) & set(chosen):
            return effect
    return ""


def make_card(name: str, role: str, verdict: dict) -> dict:
    """One effect's card; only its name where the library lacks it."""
    effect = all_effects().get(name)
    card = {"name": name, "role": role, "known": effect is not None}
    if effect is None:
        return card
    rivals = {*names(verdict, "effects"), *names(verdict, "ambiguous_with")}
    return card | {
        "title": effect.title,
        "block": effect.block,
        "equation": effect.equation,
        "source": effect.source,
        "signature": effect.signature,
        "experiment": effect.experiment,
        "parameters": [(p.name, p.meaning) for p in effect.parameters],
        "impostors": [
            {"name": other, "tell": tell, "rival": other in rivals - {name}}
            for other, tell in effect.impostors.items()
        ],
    }
