"""NI TDMS: channels by name."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError, quoted, reason
from brace_drake.core.reading import HUGE
from brace_drake.recording.importing.formats.flatten import Arrays, distinct

_PARTS = "nptdms."
_LONGEST = 200  # characters that are told of a warning


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
            raise ReadError(f"not a whole TDMS file: {warnings[0][:_LONGEST]}")
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
    # Each of its modules has a logger with a handler of its own.
    names = [n for n in logging.root.manager.loggerDict if n.startswith(_PARTS)]
    loggers = [logging.getLogger(n) for n in ("nptdms", *names)]
    kept = [(logger.handlers, logger.propagate) for logger in loggers]
    for logger in loggers:
        logger.handlers, logger.propagate = [handler], False
    try:
        yield found
    finally:
        for logger, before in zip(loggers, kept, strict=True):
            logger.handlers, logger.propagate = before


def _check_clock(name: str, start: float, step: float, samples: int) -> None:
    # Written so that NaN fails.
    if not 0.0 < step < HUGE / samples or not abs(start) < HUGE:
        raise ReadError(
            f"channel {quoted(name)}: wf_increment is {step:g} and"
            f" wf_start_offset {start:g}; allowed: a step above 0 s, and times"
            f" up to {HUGE:g} s"
        )


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
                clock = float(start), float(step), data.size
                _check_clock(channel.name, *clock)
                clocks[clock] = name
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
