"""Writes brace_protocol.h and the tables of PROTOCOL.md from the definition.

python tools/write_protocol.py
"""

import re
from collections.abc import Iterable
from pathlib import Path

from brace_drake.core.errors import OutputError
from brace_drake.core.output import WriteText
from brace_drake.link import protocol
from brace_drake.link.protocol import words
from brace_drake.link.protocol.codec import (
    MAX_STAGES,
    longest_frame,
    make_codec,
)
from brace_drake.link.protocol.limits import LIMITS, SHARED
from brace_drake.link.protocol.messages import (
    HEADER,
    KINDS,
    MESSAGES,
    ORDERED,
    VERSION,
    Field,
)
from brace_drake.link.protocol.sequence import SOON_US

_FOLDER = Path(protocol.__file__).parent
DOCUMENT = _FOLDER / "PROTOCOL.md"
HEADER_FILE = _FOLDER / "brace_protocol.h"
_TEMPLATE = _FOLDER / "brace_protocol.h.in"
_BLOCK = re.compile(r"(<!-- (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
# Prefix in C, title in the document.
_ENUMS = (
    ("STATE", "states", words.DeviceState),
    ("CAUSE", "causes", words.Cause),
    ("FLAG", "flags", words.StateFlag),
    ("MODE", "modes", words.Mode),
    ("REASON", "reasons", words.Reason),
)


def fill_tables(text: str) -> str:
    """The document with every table as the definition gives it.

    Raises:
        OutputError: A table that there is none of.
    """
    tables = {
        "header": _fields(HEADER),
        "kinds": _rows(
            ("kind", "C", "bytes"),
            ((k, c, b) for k, (_, c, b) in KINDS.items()),
        ),
        "messages": _messages(),
        "payloads": "\n".join(
            f"### {m.name}\n\n{m.meaning}\n\n{_fields(m.fields)}"
            for m in MESSAGES
        ),
        "limits": _limits(),
        "transitions": _rows(
            ("from", "to", "on", "when"),
            (
                (
                    ", ".join(s.name for s in t.before),
                    t.after.name,
                    t.on,
                    t.when,
                )
                for t in words.TRANSITIONS
            ),
        ),
    }
    for _, title, kind in _ENUMS:
        rows = ((int(w), w.name, w.meaning) for w in kind)
        tables[title] = _rows(("number", "name", "meaning"), rows)

    def fill(match: re.Match) -> str:
        if match[2] not in tables:
            raise OutputError(f"{DOCUMENT.name}: no table {match[2]}")
        return match[1] + tables[match[2]] + match[3]

    return _BLOCK.sub(fill, text)


def _rows(head: tuple[str, ...], rows: Iterable) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(str(c) for c in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def _fields(fields: tuple[Field, ...]) -> str:
    def count(field):
        fixed, each = field.count
        if each:
            return "S" if each == 1 else f"{each} S"
        return str(fixed)

    return _rows(
        ("field", "kind", "number", "unit", "meaning"),
        ((f"`{f.name}`", f.kind, count(f), f.unit, f.meaning) for f in fields),
    )


def _messages() -> str:
    rows = []
    for m in MESSAGES:
        one, three = (make_codec(stages).size(m.name) for stages in (1, 3))
        size = one if one == three else f"{one} / {three}"
        sealed = "yes" if m.sealed else ""
        rows.append(
            (m.name, f"0x{m.code:02X}", m.sender, m.feeds, sealed, size)
        )
    return _rows(
        ("message", "type", "from", "feeds", "sealed", "payload, bytes"), rows
    ) + (
        "\nTwo sizes: on a device of one stage and of three. The longest frame"
        f" has {longest_frame(3)} bytes.\n"
    )


def _limits() -> str:
    return _rows(
        ("limit", "unit", "holds as", "from", "to", "held by", "of", "meaning"),
        (
            (
                f"`{limit.name}`",
                limit.unit,
                f"at {limit.side}",
                f"{limit.least:g}",
                f"{limit.most:g}",
                "device and host" if limit.shared else "host",
                "each stage" if limit.by_stage else "all",
                limit.meaning,
            )
            for limit in LIMITS
        ),
    )


def format_header() -> str:
    """The whole C header as text."""
    structs = [_struct("header", "in front of every payload", HEADER)]
    structs += [_struct(m.name.lower(), m.meaning, m.fields) for m in MESSAGES]
    text = _TEMPLATE.read_text(encoding="utf-8")
    for mark, made in (
        ("@CONSTANTS@", _constants()),
        ("@STRUCTS@", "\n".join(structs)),
        ("@SIZES@", _sizes()),
    ):
        text = text.replace(mark + "\n", made)
    return text


def _constants() -> str:
    lines = [
        f"#define BRACE_VERSION {VERSION}",
        f"#define BRACE_MAX_STAGES {MAX_STAGES}",
        f"#define BRACE_LONGEST_FRAME {longest_frame()}",
        f"#define BRACE_NUM_LIMITS {len(SHARED)}",
        "",
    ]
    lines += [f"#define BRACE_{m.name} 0x{m.code:02X}" for m in MESSAGES]
    lines.append("\n/* What a device must refuse: limits below or above. */")
    lines += [
        f"#define BRACE_{limit.name.upper()}_{side} {float(value)!r}f"
        for limit in SHARED
        for side, value in (("LEAST", limit.least), ("MOST", limit.most))
    ]
    lines.append("\n/* What feeds the watchdog, and what the session. */")
    for what in ("watchdog", "session"):
        tests = [
            f"(t) == BRACE_{m.name}"
            for m in MESSAGES
            if m.feeds == what or (what == "session" and m.feeds == "watchdog")
        ]
        joined = " || \\\n  ".join(tests)
        lines.append(f"#define BRACE_FEEDS_{what.upper()}(t) ( \\\n  {joined})")
    lines.append(
        "\n/* What has to be newer than all of these that have come. */"
    )
    tests = " || \\\n  ".join(f"(t) == BRACE_{name}" for name in ORDERED)
    lines.append(f"#define BRACE_IS_ORDERED(t) ( \\\n  {tests})")
    lines.append(f"#define BRACE_SOON_US {SOON_US}u")
    for prefix, _, kind in _ENUMS:
        lines.append(f"\nenum brace_{prefix.lower()}_code {{")
        for w in kind:
            name = f"BRACE_{prefix}_{w.name}"
            lines.append(f"  {name} = {int(w)}, /* {w.meaning} */")
        lines.append("};")
    return "\n".join(lines) + "\n"


def _struct(name: str, meaning: str, fields: tuple[Field, ...]) -> str:
    lines = [f"/* {meaning} */", f"struct brace_{name} {{"]
    for field in fields:
        (fixed, each), unit = field.count, f", {field.unit}"
        times = "" if each == 1 else f"{each} * "
        size = f"[{fixed}]" if fixed > 1 else ""
        size = f"[{times}BRACE_STAGES]" if each else size
        comment = field.meaning + (unit if field.unit else "")
        kind = KINDS[field.kind][1]
        lines.append(f"  {kind} {field.name}{size}; /* {comment} */")
    return "\n".join([*lines, "};", ""])


def _sizes() -> str:
    """The size of each payload by its code; 0 for no message."""
    case = "    case BRACE_{}: return sizeof(struct brace_{});"
    return "\n".join(
        [
            "static inline size_t brace_payload_size(uint8_t type) {",
            "  switch (type) {",
            *(case.format(m.name, m.name.lower()) for m in MESSAGES),
            "    default: return 0;",
            "  }",
            "}",
            "",
        ]
    )


def main() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    WriteText(DOCUMENT, fill_tables(text))
    WriteText(HEADER_FILE, format_header())
    print(f"{DOCUMENT}\n{HEADER_FILE}")


if __name__ == "__main__":
    main()
