"""Bags of ROS 1 and ROS 2: numbers of a topic's messages as columns."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError, quoted
from brace_drake.recording.importing.formats.flatten import (
    Arrays,
    check_room,
    check_sample,
    pick,
)

LOG_TIME, STAMP = "log_time_s", "stamp_s"
# Longer lists of a message are pictures or scans.
_LONGEST = 64
_MOST_MESSAGES = 5_000_000


def read_ros_bag(path: Path, group: str | None) -> Arrays:
    """Numbers of a topic's messages, each (N,), in the order of logging.

    Fields within fields are named a.b, items of lists a[0], or a.NAME where
    the message says their names, as a JointState does. `log_time_s` is the
    time of logging and `stamp_s` that of the message's header, both from the
    first message on.

    Of several topics the first one's messages are the samples. The others'
    fields, named TOPIC:a.b, have at each the value that was logged last, NaN
    before the first.

    Args:
        path: Folder of a ROS 2 bag, one of its files (*.db3, *.mcap), or a
            ROS 1 bag (*.bag).
        group: The topic, or several with commas between them; not needed where
            there is one alone.

    Raises:
        ReadError: One line.
        ImportError: rosbags is not installed.
    """
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.LATEST)
    wanted = [None] if group is None else [t.strip() for t in group.split(",")]
    with AnyReader([path], default_typestore=store) as reader:
        topics = [pick("topic", reader.topics, topic) for topic in wanted]
        tables = [_read_topic(reader, topic) for topic in topics]
    columns = tables[0]
    when = columns[LOG_TIME]
    for topic, other in zip(topics[1:], tables[1:], strict=True):
        last = np.searchsorted(other[LOG_TIME], when, side="right") - 1
        for name, values in other.items():
            held = np.where(last >= 0, values[last], math.nan)
            columns[f"{topic}:{name}"] = held
    for name in {LOG_TIME, STAMP} & columns.keys():
        columns[name] = columns[name] - columns[name][0]
    return columns


def _read_topic(reader, topic: str) -> Arrays:
    """Columns of a topic that holds messages, their times as they are."""
    connections = [c for c in reader.connections if c.topic == topic]
    rows: list[dict[str, float]] = []
    names: dict[str, None] = {}
    for connection, when, data in reader.messages(connections=connections):
        message = reader.deserialize(data, connection.msgtype)
        row = {LOG_TIME: 1e-9 * when, **_row(message)}
        names.update(dict.fromkeys(row))
        rows.append(row)
        check_room(len(rows) * len(names))
        if len(rows) > _MOST_MESSAGES:
            raise ReadError(f"has more than {_MOST_MESSAGES} messages")
    if not rows:
        raise ReadError(f"topic {quoted(topic)} has no messages")
    return {
        name: np.array([row.get(name, math.nan) for row in rows])
        for name in names
    }


def _row(message) -> dict[str, float]:
    """Numbers of a message by name."""
    row: dict[str, float] = {}
    for name, value in _fields("", message):
        row[name] = value
        check_sample(len(row))
    return row


def _fields(name: str, value) -> Iterator[tuple[str, float]]:
    if isinstance(value, bool | int | float | np.number):
        yield name, float(value)
    elif isinstance(value, np.ndarray | list | tuple):
        for i, item in enumerate(value if len(value) <= _LONGEST else ()):
            yield from _fields(f"{name}[{i}]", item)
    elif dataclasses.is_dataclass(value):
        yield from _of_message(name, value)


def _of_message(name: str, message) -> Iterator[tuple[str, float]]:
    values = {
        f.name: getattr(message, f.name)
        for f in dataclasses.fields(message)
        if not f.name.startswith("_")
    }
    if set(values) == {"sec", "nanosec"}:
        stamp = STAMP if name == "header.stamp" else name
        yield stamp, values["sec"] + 1e-9 * values["nanosec"]
        return
    named = values.get("name")
    labels = named if isinstance(named, list) else []
    if len(set(labels)) < len(labels):
        labels = []
    for field, value in values.items():
        own = f"{name}.{field}" if name else field
        is_named = isinstance(value, np.ndarray) and len(value) == len(labels)
        if labels and is_named:
            for label, item in zip(labels, value, strict=True):
                yield f"{own}.{label}", float(item)
        else:
            yield from _fields(own, value)
