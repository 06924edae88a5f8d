"""Docstrings are plain text: what reStructuredText would misread is kept."""

import re

# Lines that napoleon reads as the head of a section.
_HEAD = re.compile(r"^(Args|Attributes|Raises|Returns|Yields|Example)s?:$")
_NAMES = re.compile(r"^    \w+(?:, \w+)+(?=:)")
_MARK = re.compile(r"([*|\\_])")


def as_rst(app, what, name, obj, options, lines: list[str]) -> None:
    """Escapes signs of mark-up, and keeps indented blocks as they are."""
    if what in ("property", "attribute"):
        # Napoleon takes what is before a colon for the type.
        lines[:] = [line.replace(": ", " \N{EN DASH} ") for line in lines]
    out: list[str] = []
    in_section = is_literal = False
    for line in lines:
        stripped = line.strip()
        if _HEAD.match(line):
            in_section, is_literal = True, False
            out += ["", line]
            continue
        if in_section:
            # Several names with one meaning are one field.
            line = _NAMES.sub(lambda m: m.group().replace(", ", ","), line)
        if stripped and not line.startswith(" "):
            in_section = False
            if is_literal:
                out.append("")
            is_literal = False
        if stripped and line.startswith(" ") and not in_section:
            if not is_literal:
                out += ["", "::", ""]
            is_literal = True
        out.append(line if is_literal else _escaped(line))
    lines[:] = out


def _escaped(line: str) -> str:
    """Marks outside of `names` lose their meaning."""
    parts = re.split(r"(`[^`]*`)", line)
    return "".join(
        part if part.startswith("`") else _MARK.sub(r"\\\1", part)
        for part in parts
    )
