"""NI TDMS: channels by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brace_drake.core.errors import ReadError, quoted, reason
from brace_drake.recording.importing.formats.flatten import Arrays


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
        groups = {group.name: group for group in TdmsFile.read(path).groups()}
        return _take_channels(groups, group)
    except ReadError:
        raise
    # What a reader of another's format raises on a broken file is not foreseen.
    except Exception as error:
        raise ReadError(f"not a TDMS file: {reason(error)}") from error


def _take_channels(groups: dict, wanted: str | None) -> Arrays:
    if wanted is not None and wanted not in groups:
        raise ReadError(
            f"no group {quoted(wanted)}; there are {', '.join(groups)}"
        )
    columns: Arrays = {}
    for name, group in groups.items():
        for channel in group.channels() if wanted in (None, name) else ():
            data = np.asarray(channel[:])
            if data.dtype.kind not in "fiub" or data.size < 2:
                continue
            columns[channel.name] = data.astype(float)
            step = channel.properties.get("wf_increment")
            if step and "wf_time" not in columns:
                start = channel.properties.get("wf_start_offset", 0.0)
                columns["wf_time"] = start + step * np.arange(len(channel))
    return columns
