"""brace_protocol.h, made from the definition."""

from __future__ import annotations

from pathlib import Path

from brace_drake.link.device.limits import SHARED
from brace_drake.link.protocol import words
from brace_drake.link.protocol.codec import MAX_STAGES, longest_frame
from brace_drake.link.protocol.messages import (
    HEADER,
    KINDS,
    MESSAGES,
    VERSION,
    Field,
)

FILE = Path(__file__).with_name("brace_protocol.h")
_FUNCTIONS = Path(__file__).with_name("brace_frame.inc.h")
_ENUMS = (
    ("STATE", words.DeviceState),
    ("CAUSE", words.Cause),
    ("FLAG", words.StateFlag),
    ("MODE", words.Mode),
    ("REASON", words.Reason),
)
_TOP = """\
/* Messages between a host and a brace; PROTOCOL.md says what they do.
 * Made by tools/write_protocol.py from the definition: do not edit.
 *
 * All numbers are little-endian, as on the machines this header is for. Set
 * BRACE_STAGES to the number of moving rings before including it.
 */
#ifndef BRACE_PROTOCOL_H
#define BRACE_PROTOCOL_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifndef BRACE_STAGES
#define BRACE_STAGES 1
#endif
"""


def format_header() -> str:
    """The whole header as text."""
    parts = [_TOP, _constants(), "#pragma pack(push, 1)\n"]
    parts.append(_struct("header", "in front of every payload", HEADER))
    parts += [_struct(m.name.lower(), m.meaning, m.fields) for m in MESSAGES]
    parts += ["#pragma pack(pop)\n", _sizes()]
    parts.append(_FUNCTIONS.read_text(encoding="utf-8"))
    return "\n".join(parts) + "\n#endif /* BRACE_PROTOCOL_H */\n"


def _constants() -> str:
    lines = [
        f"#define BRACE_VERSION {VERSION}",
        f"#define BRACE_MAX_STAGES {MAX_STAGES}",
        f"#define BRACE_LONGEST_FRAME {longest_frame()}",
        f"#define BRACE_NUM_LIMITS {len(SHARED)}",
        "",
    ]
    lines += [f"#define BRACE_{m.name} 0x{m.code:02X}" for m in MESSAGES]
    lines.append("\n/* What feeds the watchdog, and what the session. */")
    for what in ("watchdog", "session"):
        tests = [
            f"(t) == BRACE_{m.name}"
            for m in MESSAGES
            if m.feeds == what or (what == "session" and m.feeds == "watchdog")
        ]
        joined = " || \\\n  ".join(tests)
        lines.append(f"#define BRACE_FEEDS_{what.upper()}(t) ( \\\n  {joined})")
    for prefix, kind in _ENUMS:
        lines.append(f"\nenum brace_{prefix.lower()}_code {{")
        for word in kind:
            meaning = words.meaning_of(word)
            name = f"BRACE_{prefix}_{word.name}"
            lines.append(f"  {name} = {int(word)}, /* {meaning} */")
        lines.append("};")
    return "\n".join(lines) + "\n"


def _struct(name: str, meaning: str, fields: tuple[Field, ...]) -> str:
    lines = [f"/* {meaning} */", f"struct brace_{name} {{"]
    for field in fields:
        kind = KINDS[field.kind][1]
        unit = f", {field.unit}" if field.unit else ""
        lines.append(
            f"  {kind} {field.name}{_dimension(field)};"
            f" /* {field.meaning}{unit} */"
        )
    return "\n".join([*lines, "};", ""])


def _dimension(field: Field) -> str:
    fixed, each = field.count
    if each:
        times = "" if each == 1 else f"{each} * "
        return f"[{times}BRACE_STAGES]"
    return f"[{fixed}]" if fixed > 1 else ""


def _sizes() -> str:
    """The size of each payload by its code; 0 for no message."""
    case = "    case BRACE_{}: return sizeof(struct brace_{});"
    cases = [case.format(m.name, m.name.lower()) for m in MESSAGES]
    return "\n".join(
        [
            "static inline size_t brace_payload_size(uint8_t type) {",
            "  switch (type) {",
            *cases,
            "    default: return 0;",
            "  }",
            "}",
            "",
        ]
    )
