"""Consistent overhead byte stuffing: any bytes without a zero among them.

Cheshire and Baker, Consistent Overhead Byte Stuffing, IEEE/ACM Transactions on
Networking 7(2), 1999. A code byte c stands for c - 1 bytes that follow and a
zero behind them; 255 stands for 254 bytes and no zero; the last block has none.
"""

from __future__ import annotations

_LONGEST = 254


def stuff(data: bytes) -> bytes:
    """The data without zeros, at most one byte in 254 longer, and one."""
    out = bytearray()
    blocks = data.split(b"\0")
    for block in blocks[:-1]:
        while len(block) >= _LONGEST:
            out += b"\xff" + block[:_LONGEST]
            block = block[_LONGEST:]
        out.append(len(block) + 1)
        out += block
    block = blocks[-1]
    while len(block) > _LONGEST:
        out += b"\xff" + block[:_LONGEST]
        block = block[_LONGEST:]
    out.append(len(block) + 1)
    out += block
    return bytes(out)


def unstuff(data: bytes) -> bytes | None:
    """What `stuff` was given; None where the codes do not fit together."""
    out = bytearray()
    at, end = 0, len(data)
    while at < end:
        code = data[at]
        after = at + code
        if code == 0 or after > end:
            return None
        out += data[at + 1 : after]
        if code <= _LONGEST and after < end:
            out.append(0)
        at = after
    return bytes(out)
