"""Effects that a scenario carries: named values in a file, laws in the twin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.core.errors import suggest
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import PLACES, effects_for
from brace_drake.effects.stack import Use
from brace_drake.effects.stage_cards import stages_within_tolerances
from brace_drake.effects.unknown import terms_for
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.scenario.brace import EffectUse
from brace_drake.scenario.fields import fail

# A value may pass its limit by this part of the range: fits scale parameters,
# and rounding brings a value at its limit back a little beside it.
_ROUNDING = 1e-9


def scenario_uses(scenario) -> tuple[Use, ...]:
    """Effects of a checked scenario with their parameter vectors.

    What single runs have of their own, such as the phase of a breath, is 0.
    """
    uses = []
    for use in scenario.effects:
        card = _cards(use.name, scenario)[use.form]
        values = [float(use.parameters[n]) for n in card.parameter_names]
        uses.append((card, card.in_run(np.array(values), 0)))
    return tuple(uses)


def describe_use(effect: Effect, values: np.ndarray) -> EffectUse:
    """An effect with its parameters as a scenario holds it.

    Args:
        effect: The card.
        values: Its parameters; run parameters behind them are left out.
    """
    named = zip(effect.parameter_names, values, strict=False)
    return EffectUse(
        effect.name, {n: float(v) for n, v in named}, effect.variant
    )


def effects_of(scenario) -> dict[str, Effect]:
    """Cards of the effects that a scenario's device can have, by key; in its
    own units where it has such.
    """
    own = getattr(scenario, "own_effects", None)
    return own() if own else effects_for(scenario.device)


def check_effects(source: str, scenario) -> None:
    """Checks names, forms and parameters of a scenario's effects.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    effects: Sequence[EffectUse] = scenario.effects
    if len(effects) > MAX_EFFECTS:
        names = [use.name for use in effects]
        fail(source, "effects", names, f"at most {MAX_EFFECTS} effects")
    for i, use in enumerate(effects):
        _check_use(source, f"effects[{i}]", use, scenario)


def _check_use(source: str, at: str, use: EffectUse, scenario) -> None:
    forms = _cards(use.name, scenario)
    if not forms:
        names = {c.name for c in effects_of(scenario).values()}
        allowed = f"an effect of a {scenario.device}{suggest(use.name, names)}"
        fail(source, f"{at}.name", use.name, allowed)
    if use.form not in forms:
        allowed = " or ".join(repr(f) for f in forms if f)
        fail(source, f"{at}.form", use.form, allowed or "none")
    card = forms[use.form]
    for name, value in use.parameters.items():
        if name not in card.parameter_names:
            hint = suggest(name, card.parameter_names)
            allowed = f"no such parameter of {card.key}{hint}"
            fail(source, f"{at}.parameters.{name}", value, allowed)
    for parameter in card.parameters:
        path = f"{at}.parameters.{parameter.name}"
        if parameter.name not in use.parameters:
            fail(source, path, None, f"a value: {parameter.meaning}")
        _check_value(source, path, use.parameters[parameter.name], parameter)


def _check_value(source: str, path: str, value: float, parameter) -> None:
    low, high = parameter.lower, parameter.upper
    slack = _ROUNDING * (high - low)
    if parameter.choices:
        if value not in parameter.choices:
            words = " or ".join(f"{c:g}" for c in parameter.choices)
            fail(source, path, value, words)
    elif not low - slack <= value <= high + slack:
        fail(source, path, value, f"{low:g} to {high:g} {parameter.unit}")


def _cards(name: str, scenario) -> dict[str, Effect]:
    """Cards of a name by form; the first also stands for no form at all.

    A machine off within its tolerances is none of the library's, and may be
    carried all the same; so are terms of a law.
    """
    cards = [c for c in effects_of(scenario).values() if c.name == name]
    known = PLACES.get(scenario.device, frozenset())
    stages = getattr(scenario, "stages", [0])
    off = stages_within_tolerances(stages)
    if name == off.name and off.places <= known:
        cards.append(off)
    cards += [c for n, c in terms_for(scenario.device).items() if n == name]
    forms = {card.variant: card for card in cards}
    if cards:
        forms.setdefault("", cards[0])
    return forms
