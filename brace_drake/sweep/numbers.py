"""Numbers of a scenario by their paths, as in "contact.ring2.stiffness"."""

from __future__ import annotations

import copy
import dataclasses
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from brace_drake.core.errors import ScenarioError, quoted, suggest
from brace_drake.recording.columns import BRACE_STAGES
from brace_drake.scenario.check import CheckScenario
from brace_drake.scenario.effects import scenario_uses
from brace_drake.scenario.fields import Limits

_EFFECTS = "effects"


@dataclass(frozen=True)
class ScenarioNumber:
    """One number of a scenario.

    Attributes:
        path: Where it stands in the file; "torso.mass", one of an array as
            "torso.posture_stiffness[1]", of an effect as "effects.NAME.KEY".
        unit: As declared; empty for none.
        value: In the scenario.
        is_whole: Whether it has to be a whole number.
    """

    path: str
    unit: str
    value: float
    is_whole: bool = False


def scenario_numbers(scenario: Any) -> dict[str, ScenarioNumber]:
    """All numbers of a scenario that its fields declare, by path.

    Numbers of rings and stages that do not move have no effect: they are left
    out.
    """
    moving = getattr(scenario, "stages", None)
    still = [i for i in BRACE_STAGES if moving and i not in moving]
    out = tuple(f".{part}{i}" for i in still for part in ("ring", "stage"))
    found = (*_declared(scenario, ""), *_effects(scenario))
    return {n.path: n for n in found if not any(o in n.path for o in out)}


def find_number(scenario: Any, path: str, source: str) -> ScenarioNumber:
    """The number of a path.

    A part of the path that only one moving ring can stand for may be left out:
    "contact.stiffness" of the bench is "contact.ring2.stiffness".

    Raises:
        ScenarioError: There is none; the message offers the closest.
    """
    known = scenario_numbers(scenario)
    if path in known:
        return known[path]
    own = [name for name in known if _is_short_for(path, name, scenario)]
    if len(own) == 1:
        return known[own[0]]
    if f"{path}[0]" in known:
        raise ScenarioError(
            f"{source}: {path} is an array; allowed: one of its numbers, as in"
            f" {path}[0]"
        )
    below = [name for name in known if name.startswith(f"{path}.")]
    if below:
        raise ScenarioError(
            f"{source}: {path} is no number; allowed: one below it, as in"
            f" {below[0]}"
        )
    if own:
        raise ScenarioError(
            f"{source}: {path} may be any of {', '.join(own)}; allowed: one"
        )
    shown = path if path.isprintable() else repr(path)
    raise ScenarioError(
        f"{source}: {quoted(shown)[1:-1]}: no such number{_hint(path, known)}"
    )


def _hint(path: str, known: dict[str, ScenarioNumber]) -> str:
    """The closest path, by its last part where the whole is like none."""
    found = suggest(path, known)
    if found:
        return found
    last = path.rpartition(".")[2]
    ends = {name.rpartition(".")[2]: name for name in reversed(known)}
    close = suggest(last, ends).removeprefix(", did you mean ").rstrip("?")
    return f", did you mean {ends[close]}?" if close else ""


def _is_short_for(path: str, name: str, scenario: Any) -> bool:
    """Whether a path leaves out the moving ring of a number's name."""
    rings = getattr(scenario, "rings", ())
    left_out = [name.replace(f".{r}.", ".", 1) for r in rings if r in name]
    return path in left_out


def _declared(node: Any, at: str) -> Iterator[ScenarioNumber]:
    for f in dataclasses.fields(node):
        path, value = f"{at}{f.name}", getattr(node, f.name)
        if dataclasses.is_dataclass(value):
            yield from _declared(value, f"{path}.")
            continue
        limits = f.metadata.get("limits", Limits())
        if isinstance(value, np.ndarray):
            for i, entry in enumerate(value):
                yield ScenarioNumber(f"{path}[{i}]", limits.unit, float(entry))
        elif isinstance(value, dict):
            for key, entry in value.items():
                yield ScenarioNumber(f"{path}.{key}", limits.unit, float(entry))
        elif type(value) in (int, float):
            whole = type(value) is int
            yield ScenarioNumber(path, limits.unit, float(value), whole)


def _effects(scenario: Any) -> Iterator[ScenarioNumber]:
    """Parameters of the effects that a scenario carries."""
    for card, values in scenario_uses(scenario):
        for p, value in zip(card.parameters, values, strict=False):
            path = f"{_EFFECTS}.{card.name}.{p.name}"
            yield ScenarioNumber(path, p.unit, float(value))


def with_number(
    scenario: Any, number: ScenarioNumber, value: float, source: str
) -> Any:
    """A checked copy of a scenario with another value of one number.

    Raises:
        ScenarioError: The value is not allowed there; the message says what is.
    """
    if number.is_whole and value != round(value):
        raise ScenarioError(
            f"{source}: {number.path} is {value:g}; allowed: whole numbers"
        )
    out = copy.deepcopy(scenario)
    first, *keys = number.path.split(".")
    if first == _EFFECTS:
        name, key = keys
        (use,) = (u for u in out.effects if u.name == name)
        use.parameters[key] = float(value)
    else:
        _set(out, [first, *keys], value, number.is_whole)
    CheckScenario(out, source)
    return out


def _set(node: Any, keys: list[str], value: float, is_whole: bool) -> None:
    for key in keys[:-1]:
        node = node[key] if isinstance(node, dict) else getattr(node, key)
    last = keys[-1]
    match = re.fullmatch(r"(\w+)\[(\d+)\]", last)
    if isinstance(node, dict):
        node[last] = float(value)
    elif match:
        getattr(node, match[1])[int(match[2])] = value
    else:
        setattr(node, last, round(value) if is_whole else float(value))
