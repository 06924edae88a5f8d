"""Reads the commands that a static Meshcat page holds."""

import base64
import re
import struct


def read_commands(page):
    """The commands of a page, in order, as maps."""
    found = re.findall(r'octet-binary;base64,([A-Za-z0-9+/=]+)"', page)
    commands = []
    for text in found:
        value, rest = unpack(base64.b64decode(text))
        assert not rest
        if isinstance(value, dict) and "type" in value:
            commands.append(value)
    return commands


def read_tracks(page):
    """Of the page's animation: rate, and keys by path and property."""
    (command,) = (
        c for c in read_commands(page) if c["type"] == "set_animation"
    )
    tracks, rates = {}, set()
    for part in command["animations"]:
        rates.add(part["clip"]["fps"])
        for track in part["clip"]["tracks"]:
            keys = {k["time"]: k["value"] for k in track["keys"]}
            tracks[part["path"], track["name"]] = keys
    (rate,) = rates
    return rate, tracks


def unpack(data):
    """One value of MessagePack (msgpack.org), and the bytes after it."""
    head, rest = data[0], data[1:]
    if head < 0x80:
        return head, rest
    if head < 0x90:
        return _take_map(head & 0x0F, rest)
    if head < 0xA0:
        return _take_list(head & 0x0F, rest)
    if head < 0xC0:
        return _take_text(head & 0x1F, rest)
    if head >= 0xE0:
        return head - 0x100, rest
    if head in _PLAIN:
        return _PLAIN[head], rest
    if head in _NUMBERS:
        form = _NUMBERS[head]
        size = struct.calcsize(form)
        return struct.unpack(form, rest[:size])[0], rest[size:]
    form, take = _SIZED[head]
    size = struct.calcsize(form)
    return take(struct.unpack(form, rest[:size])[0], rest[size:])


def _take_text(size, rest):
    return rest[:size].decode(), rest[size:]


def _take_bytes(size, rest):
    return rest[:size], rest[size:]


def _take_extension(size, rest):
    return rest[1 : 1 + size], rest[1 + size :]


def _take_list(size, rest):
    values = []
    for _ in range(size):
        value, rest = unpack(rest)
        values.append(value)
    return values, rest


def _take_map(size, rest):
    values, rest = _take_list(2 * size, rest)
    return dict(zip(values[::2], values[1::2], strict=True)), rest


_PLAIN = {0xC0: None, 0xC2: False, 0xC3: True}
_NUMBERS = {
    0xCA: ">f", 0xCB: ">d", 0xCC: ">B", 0xCD: ">H", 0xCE: ">I", 0xCF: ">Q",
    0xD0: ">b", 0xD1: ">h", 0xD2: ">i", 0xD3: ">q",
}  # fmt: skip
_SIZED = {
    0xC4: (">B", _take_bytes), 0xC5: (">H", _take_bytes),
    0xC6: (">I", _take_bytes), 0xC7: (">B", _take_extension),
    0xC8: (">H", _take_extension), 0xC9: (">I", _take_extension),
    0xD9: (">B", _take_text), 0xDA: (">H", _take_text),
    0xDB: (">I", _take_text), 0xDC: (">H", _take_list),
    0xDD: (">I", _take_list), 0xDE: (">H", _take_map),
    0xDF: (">I", _take_map),
}  # fmt: skip
