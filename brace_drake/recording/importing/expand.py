"""Rules of a map that stand for several channels.

`leg{1..6}_length_m: "len_{}"` is six rules. Braces on the left give each its
value, a range of numbers or a list; `{}` on the right is that value, and other
braces on the right have values of their own, as many: `"L{0..5} (mm)"`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from brace_drake.core.errors import CampaignError, quoted
from brace_drake.recording.importing.rules import MOST_ADDED

_BRACES = re.compile(r"\{([^{}]*)\}")
_MOST = 1000  # channels
_RANGE = re.compile(r"(\d{1,3})\.\.(\d{1,3})")


def expand_rules(place: str, rules: Mapping) -> dict[str, object]:
    """Rules of one channel each.

    Args:
        place: Of the map, for messages.
        rules: By channel, whose name may have braces.

    Raises:
        CampaignError: Braces that do not fit each other, or a channel that is
            there twice.
    """
    found: dict[str, object] = {}
    for name, rule in rules.items():
        for channel, own in _expand(f"{place}{name}", str(name), rule):
            if channel in found:
                raise CampaignError(f"{place}{channel} is there twice")
            found[channel] = own
            if len(found) > _MOST:
                raise CampaignError(
                    f"{place}{name} and others: allowed: {_MOST} channels"
                )
    return found


def _expand(place: str, name: str, rule: object) -> list[tuple[str, object]]:
    braces = _BRACES.findall(name)
    if not braces:
        return [(name, rule)]
    if len(braces) > 1:
        raise CampaignError(f"{place}: allowed: one pair of braces")
    values = _values(place, braces[0])
    if len(values) > _MOST:
        raise CampaignError(f"{place}: allowed: {_MOST} channels")
    return [
        (_BRACES.sub(value, name), _fill(place, rule, values, i))
        for i, value in enumerate(values)
    ]


def _values(place: str, text: str) -> list[str]:
    found = _RANGE.fullmatch(text)
    if found:
        first, last = map(int, found.groups())
        step = 1 if last >= first else -1
        return [str(i) for i in range(first, last + step, step)]
    values = [value.strip() for value in text.split(",")]
    if not all(values):
        raise CampaignError(
            f"{place}: {{{text}}}; allowed: a range as {{1..6}} or a list as"
            " {x,y,z}"
        )
    return values


def _fill(place: str, rule: object, values: list[str], i: int) -> object:
    """The i-th channel's rule: texts within it with their braces filled."""
    if isinstance(rule, dict):
        if len(rule) > MOST_ADDED:
            raise CampaignError(f"{place}: allowed: {MOST_ADDED} columns")
        # Columns of a sum are keys.
        filled = {
            _fill(place, key, values, i): _fill(place, item, values, i)
            for key, item in rule.items()
        }
        if len(filled) < len(rule):
            raise CampaignError(f"{place}: a column is added up twice")
        return filled
    if not isinstance(rule, str):
        return rule

    def own(found: re.Match) -> str:
        if not found[1]:
            return values[i]
        others = _values(place, found[1])
        if len(others) != len(values):
            raise CampaignError(
                f"{place}: {quoted(found[0])} has {len(others)} values;"
                f" allowed: {len(values)}, as the channel's name has"
            )
        return others[i]

    return _BRACES.sub(own, rule)
