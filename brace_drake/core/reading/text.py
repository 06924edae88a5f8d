"""Bytes as text, and how large numbers in a text may be."""

from brace_drake.core.errors import ReadError

# Far beyond any quantity in SI units, and far from where laws overflow.
HUGE = 1e12


def decode(data: bytes) -> str:
    """UTF-8 text, with or without a mark of byte order.

    Raises:
        ReadError: It is none; the message names the line.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise ReadError(f"not UTF-8 text (line {line})") from error
