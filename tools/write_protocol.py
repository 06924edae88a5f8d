"""Writes the tables of PROTOCOL.md and brace_protocol.h from the definition.

python tools/write_protocol.py
"""

from brace_drake.core.output import WriteText
from brace_drake.link.protocol.c_header import FILE, format_header
from brace_drake.link.protocol.document import DOCUMENT, fill_tables


def main() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    WriteText(DOCUMENT, fill_tables(text))
    WriteText(FILE, format_header())
    print(f"{DOCUMENT}\n{FILE}")


if __name__ == "__main__":
    main()
