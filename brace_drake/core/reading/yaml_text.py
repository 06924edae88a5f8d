"""YAML, bounded, and without its surprises.

Maps, lists, words, decimal numbers, true and false. Dates, times and numbers
of other bases are words. A key is a word or a whole number, and is there once.
Aliases may stand for what has an anchor, as long as all that they stand for
stays within bounds.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from brace_drake.core.errors import BraceError, ReadError, is_plain, quoted
from brace_drake.core.reading.files import ReadBytes, in_file
from brace_drake.core.reading.text import decode

LARGEST_MB = 4
DEEPEST = 32
MOST_NODES = 200_000  # Aliases count as what they stand for.
LONGEST = 10_000  # characters of a word
MOST_DIGITS = 18  # Longer ones are words.

# Between thousands alone may a line stand: 2_00 is a slip, not 200.
_THOUSANDS = r"[0-9]{1,3}(?:_[0-9]{3})+"
_WHOLE = re.compile(rf"[-+]?(?:0|(?=[1-9])(?:{_THOUSANDS}|[0-9]+))")
_NUMBER = re.compile(
    rf"[-+]?(?:(?:{_THOUSANDS}|[0-9]+)\.[0-9]*|\.[0-9]+)(?:[eE][-+][0-9]+)?"
)
_WORDS: dict[str, object] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys("true True TRUE yes Yes YES on On ON".split(), True),
    **dict.fromkeys("false False FALSE no No NO off Off OFF".split(), False),
    **dict.fromkeys(".inf .Inf .INF +.inf +.Inf +.INF".split(), math.inf),
    **dict.fromkeys("-.inf -.Inf -.INF".split(), -math.inf),
    **dict.fromkeys(".nan .NaN .NAN".split(), math.nan),
}
_MERGE = "<<"  # takes over the keys of other maps
_SPACES = dict.fromkeys(map(ord, "\t\n"), " ")
_TAG = "tag:yaml.org,2002:"
_KINDS: dict[str, type | tuple[type, ...]] = {
    "str": str,
    "int": int,
    "float": (int, float),
    "bool": bool,
    "null": type(None),
    "map": dict,
    "seq": list,
}


def LoadYaml(
    path: str | Path, error: type[BraceError], may_be_empty: bool = False
) -> dict:
    """The map that a YAML file holds; see `parse_yaml`.

    Raises:
        error: One line: the file, its line, and what is wrong.
    """
    with in_file(path, error):
        return parse_yaml(ReadBytes(path, LARGEST_MB), may_be_empty)


def parse_yaml(data: bytes | str, may_be_empty: bool = False) -> dict:
    """The map that YAML text holds.

    Args:
        data: The text.
        may_be_empty: Whether a text without anything is a map without keys.

    Raises:
        ReadError: One line.
    """
    text = data if isinstance(data, str) else decode(data)
    if "\0" in text:
        raise ReadError("not YAML: it holds null bytes")
    builder = _Builder()
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        for event in yaml.parse(text, Loader=loader):
            builder.add(event)
    except yaml.YAMLError as error:
        place = _place(getattr(error, "problem_mark", None))
        problem = getattr(error, "problem", None) or error
        raise ReadError(f"not YAML{place}: {problem}") from error
    except (UnicodeError, RecursionError) as error:
        raise ReadError(f"not YAML: {error}") from error
    found = builder.found
    if found is None and may_be_empty:
        return {}
    if not isinstance(found, dict):
        # Its kind alone: what a file holds that is none of ours is not shown.
        raise ReadError(f"must hold a mapping of keys, found {_kind(found)}")
    return found


def _kind(found: object) -> str:
    """Of a value, in a word."""
    if found is None:
        return "nothing"
    if isinstance(found, list):
        return "a list"
    return "a text" if isinstance(found, str) else "a value"


def _place(mark: Any) -> str:
    """Of a parser's mark, in words; nothing without one."""
    return f" in line {mark.line + 1}" if mark is not None else ""


@dataclass
class _Open:
    """A map or a list whose end has not come yet."""

    node: dict | list
    anchor: str | None
    before: int  # nodes before its own
    key: object = None
    has_key: bool = False
    merged: list[dict] = field(default_factory=list)


class _Builder:
    """Makes values of a parser's events, without recursion."""

    def __init__(self) -> None:
        self.found: object = None
        self._open: list[_Open] = []
        self._named: dict[str, tuple[object, int]] = {}
        self._nodes = self._documents = 0

    def add(self, event: yaml.Event) -> None:
        """Takes the next event.

        Raises:
            ReadError: One line, with that of the text.
        """
        try:
            self._add(event)
        except ReadError as error:
            place = _place(event.start_mark)
            raise ReadError(f"not YAML{place}: {error}") from error

    def _add(self, event: yaml.Event) -> None:
        if isinstance(event, yaml.ScalarEvent):
            self._count(1)
            self._name(event.anchor, _scalar(event), self._nodes - 1)
        elif isinstance(event, yaml.CollectionStartEvent):
            self._count(1)
            self._begin(event)
        elif isinstance(event, yaml.CollectionEndEvent):
            done = self._open.pop()
            if isinstance(done.node, dict):
                for base in done.merged:
                    for key, value in base.items():
                        done.node.setdefault(key, value)
            self._name(done.anchor, done.node, done.before)
        elif isinstance(event, yaml.AliasEvent):
            if event.anchor not in self._named:
                raise ReadError(f"alias *{event.anchor} stands for nothing yet")
            value, size = self._named[event.anchor]
            self._count(size)
            self._put(value)
        elif isinstance(event, yaml.DocumentStartEvent):
            self._documents += 1
            if self._documents > 1:
                raise ReadError("a second document; allowed: one")

    def _count(self, nodes: int) -> None:
        self._nodes += nodes
        if self._nodes > MOST_NODES:
            raise ReadError(
                f"more than {MOST_NODES} values, those of aliases included"
            )

    def _begin(self, event: yaml.CollectionStartEvent) -> None:
        if len(self._open) == DEEPEST:
            raise ReadError(f"more than {DEEPEST} levels within another")
        above = self._open[-1] if self._open else None
        is_map = isinstance(event, yaml.MappingStartEvent)
        node: dict | list = {} if is_map else []
        if above and isinstance(above.node, dict) and not above.has_key:
            _check_key(node)
        _check_tag(event.tag, node)
        self._open.append(_Open(node, event.anchor, self._nodes - 1))

    def _name(self, anchor: str | None, value: object, before: int) -> None:
        if anchor is not None:
            self._named[anchor] = value, self._nodes - before
        self._put(value)

    def _put(self, value: object) -> None:
        """Where a value belongs: an item, a key or what is behind one."""
        if not self._open:
            self.found = value
            return
        above = self._open[-1]
        if isinstance(above.node, list):
            above.node.append(value)
        elif not above.has_key:
            _check_key(value)
            if value in above.node:
                raise ReadError(f"key {quoted(value)} is there twice")
            above.key, above.has_key = value, True
        else:
            above.has_key = False
            if above.key == _MERGE:
                above.merged += _bases(value)
            else:
                above.node[above.key] = value


def _check_key(value: object) -> None:
    """A key is a word or a whole number: in Python 1, 1.0 and true are one."""
    if isinstance(value, dict | list):
        raise ReadError("a map or a list as a key; allowed: a word")
    if not isinstance(value, str) and type(value) is not int:
        kind = {bool: "true or false", type(None): "null"}
        raise ReadError(
            f"a key that is {kind.get(type(value), quoted(value))}; allowed: a"
            " word or a whole number; quotes make a word of anything"
        )


def _bases(value: object) -> list[dict]:
    """The maps whose keys a map takes over, the first one first."""
    bases = value if isinstance(value, list) else [value]
    maps = [base for base in bases if isinstance(base, dict)]
    if len(maps) < len(bases):
        raise ReadError(f"{_MERGE} takes over {quoted(value)}; allowed: maps")
    return maps


def _scalar(event: yaml.ScalarEvent) -> object:
    """A word, or what it stands for."""
    text = event.value
    if len(text) > LONGEST:
        raise ReadError(f"a word of {len(text)} characters")
    if not is_plain(text.translate(_SPACES)):
        raise ReadError(f"{quoted(text)} holds control characters")
    # Quotes and the tag ! make a word of anything.
    is_quoted = event.tag is None and not event.implicit[0]
    if is_quoted or event.tag in ("!", f"{_TAG}str"):
        return text
    value = _value_of(text)
    _check_tag(event.tag, value)
    return value


def _value_of(text: str) -> object:
    if text in _WORDS:
        return _WORDS[text]
    if _WHOLE.fullmatch(text):
        digits = text.replace("_", "")
        return int(digits) if len(digits) <= MOST_DIGITS else text
    if _NUMBER.fullmatch(text):
        value = float(text.replace("_", ""))
        if math.isinf(value):
            raise ReadError(f"{quoted(text)} is beyond any number")
        return value
    return text


def _check_tag(tag: str | None, value: object) -> None:
    if tag in (None, "!"):
        return
    kind = _KINDS.get(tag.removeprefix(_TAG)) if tag.startswith(_TAG) else None
    if kind is None:
        raise ReadError(f"tag {quoted(tag)}; allowed: none")
    if not isinstance(value, kind):
        raise ReadError(f"{quoted(value)} is not what its tag says")
