"""NI TDMS: channels by name."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError, quoted, reason
from brace_drake.recording.importing.formats.flatten import Arrays, distinct


def read_tdms(path: Path, group: str | None) -> Arrays:
    """Channels, and `wf_time` where waveforms say their time themselves.

    Args:
        path: *.tdms.
        group: The group to look in; by default all.

    Raises:
        ReadError: One line.
    """
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise ReadError("TDMS needs npTDMS: pip install -e '.[lab]'") from error
    try:
        with _told() as warnings:
            groups = {g.name: g for g in TdmsFile.read(path).groups()}
            columns = _take_channels(groups, group)
        if warnings:
            raise ReadError(f"not a whole TDMS file: {warnings[0]}")
        return columns
    except ReadError:
        raise
    # On a broken file a reader of another's format may raise any exception.
    except Exception as error:
        raise ReadError(f"not a TDMS file: {reason(error)}") from error


@contextlib.contextmanager
def _told() -> Iterator[list[str]]:
    """What nptdms warns of, which then is not printed."""
    found: list[str] = []
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: found.append(  # type: ignore[method-assign]
        " ".join(record.getMessage().split())
    )
    logger = logging.getLogger("nptdms")
    kept = logger.handlers, logger.propagate
    logger.handlers, logger.propagate = [handler], False
    try:
        yield found
    finally:
        logger.handlers, logger.propagate = kept


def _take_channels(groups: dict, wanted: str | None) -> Arrays:
    if wanted is not None and wanted not in groups:
        raise ReadError(
            f"no group {quoted(wanted)}; there are {', '.join(groups)}"
        )
    names, arrays, clocks = [], [], {}
    for name, group in groups.items():
        for channel in group.channels() if wanted in (None, name) else ():
            data = np.asarray(channel[:])
            if data.dtype.kind not in "fiub" or data.size < 2:
                continue
            names.append(channel.name)
            arrays.append(data.astype(float))
            step = channel.properties.get("wf_increment")
            if step:
                start = channel.properties.get("wf_start_offset", 0.0)
                clocks[float(start), float(step), data.size] = name
    if len(clocks) > 1:
        owners = dict.fromkeys(clocks.values())
        raise ReadError(
            "channels have clocks of their own; options.group must name one"
            f" group of {', '.join(map(quoted, owners))}"
        )
    columns: Arrays = dict(zip(distinct(names), arrays, strict=True))
    for start, step, samples in clocks:
        columns.setdefault("wf_time", start + step * np.arange(samples))
    return columns
