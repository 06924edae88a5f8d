"""The tables of PROTOCOL.md, made from the definition."""

from __future__ import annotations

import re
from pathlib import Path

from brace_drake.core.errors import OutputError
from brace_drake.link.device.limits import LIMITS
from brace_drake.link.protocol import words
from brace_drake.link.protocol.codec import longest_frame, make_codec
from brace_drake.link.protocol.messages import HEADER, KINDS, MESSAGES, Field

DOCUMENT = Path(__file__).with_name("PROTOCOL.md")
_BLOCK = re.compile(r"(<!-- (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
_ENUMS = {
    "states": words.DeviceState,
    "causes": words.Cause,
    "flags": words.StateFlag,
    "modes": words.Mode,
    "reasons": words.Reason,
}


def fill_tables(text: str) -> str:
    """The document with every table as the definition gives it.

    Raises:
        OutputError: A table that there is none of.
    """

    def fill(match: re.Match) -> str:
        name = match[2]
        if name not in _TABLES:
            raise OutputError(f"{DOCUMENT.name}: no table {name}")
        return match[1] + _TABLES[name]() + match[3]

    return _BLOCK.sub(fill, text)


def _rows(head: tuple[str, ...], rows) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(str(c) for c in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def _count(field: Field) -> str:
    fixed, each = field.count
    if each:
        return "S" if each == 1 else f"{each} S"
    return str(fixed)


def _fields(fields: tuple[Field, ...]) -> str:
    return _rows(
        ("field", "kind", "number", "unit", "meaning"),
        ((f"`{f.name}`", f.kind, _count(f), f.unit, f.meaning) for f in fields),
    )


def _messages() -> str:
    head = ("message", "type", "from", "feeds", "sealed", "payload, bytes")
    rows = []
    for m in MESSAGES:
        sizes = [make_codec(stages).size(m.name) for stages in (1, 3)]
        size = sizes[0] if sizes[0] == sizes[1] else f"{sizes[0]} / {sizes[1]}"
        sealed = "yes" if m.sealed else ""
        rows.append(
            (m.name, f"0x{m.code:02X}", m.sender, m.feeds, sealed, size)
        )
    note = (
        "\nTwo sizes: on a device of one stage and of three. The longest frame"
        f" has {longest_frame(3)} bytes.\n"
    )
    return _rows(head, rows) + note


def _payloads() -> str:
    parts = []
    for m in MESSAGES:
        parts.append(f"### {m.name}\n\n{m.meaning}\n\n{_fields(m.fields)}")
    return "\n".join(parts)


def _limits() -> str:
    return _rows(
        ("limit", "unit", "holds as", "held by", "of", "meaning"),
        (
            (
                f"`{limit.name}`",
                limit.unit,
                f"at {limit.side}",
                "device and host" if limit.shared else "host",
                "each stage" if limit.by_stage else "all",
                limit.meaning,
            )
            for limit in LIMITS
        ),
    )


def _words(kind) -> str:
    rows = ((int(w), w.name, words.meaning_of(w)) for w in kind)
    return _rows(("number", "name", "meaning"), rows)


_TABLES = {
    "header": lambda: _fields(HEADER),
    "kinds": lambda: _rows(
        ("kind", "C", "bytes"), ((k, c, b) for k, (_, c, b) in KINDS.items())
    ),
    "messages": _messages,
    "payloads": _payloads,
    "limits": _limits,
    **{n: (lambda kind=kind: _words(kind)) for n, kind in _ENUMS.items()},
}
