"""Bags of ROS 1 and ROS 2: numbers of a topic's messages as columns."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError
from brace_drake.recording.importing.formats.flatten import (
    Arrays,
    check_room,
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

    Args:
        path: Folder of a ROS 2 bag, one of its files (*.db3, *.mcap), or a
            ROS 1 bag (*.bag).
        group: The topic; not needed where there is one alone.

    Raises:
        ReadError: One line.
        ImportError: rosbags is not installed.
    """
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.LATEST)
    with AnyReader([path], default_typestore=store) as reader:
        topic = pick("topic", reader.topics, group)
        connections = [c for c in reader.connections if c.topic == topic]
        rows: list[dict[str, float]] = []
        names: dict[str, None] = {}
        for connection, when, data in reader.messages(connections=connections):
            message = reader.deserialize(data, connection.msgtype)
            row = {LOG_TIME: 1e-9 * when, **dict(_fields("", message))}
            names.update(dict.fromkeys(row))
            rows.append(row)
            check_room(len(rows) * len(names))
            if len(rows) > _MOST_MESSAGES:
                raise ReadError(f"has more than {_MOST_MESSAGES} messages")
    columns = {
        name: np.array([row.get(name, math.nan) for row in rows])
        for name in names
    }
    for name in {LOG_TIME, STAMP} & columns.keys():
        columns[name] = columns[name] - columns[name][0]
    return columns


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
    for field, value in values.items():
        own = f"{name}.{field}" if name else field
        is_named = isinstance(value, np.ndarray) and len(value) == len(labels)
        if labels and is_named:
            for label, item in zip(labels, value, strict=True):
                yield f"{own}.{label}", float(item)
        else:
            yield from _fields(own, value)
