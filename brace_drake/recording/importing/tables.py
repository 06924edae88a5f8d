"""Columns of a file by name, whatever wrote it."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError, quoted, reason
from brace_drake.core.reading import ReadBytes, check_file, in_file
from brace_drake.core.reading.rows import decode_lines, read_rows
from brace_drake.recording.fields import TEXT, Field
from brace_drake.recording.importing.matlab_file import read_matlab
from brace_drake.recording.importing.mcap_file import LoadMcapTable
from brace_drake.recording.table import Columns

_SIGN = Field(
    "one character",
    lambda v: isinstance(v, str) and len(v) == 1 and v not in '\r\n\0"',
    required=False,
)
# What may be said of a file beside its columns.
OPTIONS = {
    "delimiter": _SIGN,
    "decimal": _SIGN,
    "skip_lines": Field(
        "a whole number, 0 or more",
        lambda v: type(v) is int and v >= 0,
        required=False,
    ),
    "group": TEXT,
}


def LoadTable(path: str | Path, options: dict) -> Columns:
    """Reads a file's columns, each (N,).

    Args:
        path: *.csv or *.txt, *.mat, *.tdms, *.mcap.
        options: See `OPTIONS`. Of CSV: `delimiter`, `decimal`, `skip_lines`.
            Of MATLAB and TDMS: `group`, the struct or group to look in; of
            MCAP the topic.

    Raises:
        CampaignError: One line: file, and what is wrong with it.
    """
    path = Path(path)
    readers = {
        ".mat": _LoadMatlab,
        ".tdms": _LoadTdms,
        ".mcap": LoadMcapTable,
        **dict.fromkeys((".csv", ".txt", ".tsv"), _LoadText),
    }
    reader = readers.get(path.suffix.lower())
    if reader is None:
        ending = path.suffix.lower() or "no ending"
        raise CampaignError(f"{path}: {ending}; known are {', '.join(readers)}")
    with in_file(path, CampaignError):
        check_file(path)
    columns = reader(path, options)
    if not columns:
        raise CampaignError(f"{path}: no column of numbers there")
    return columns


def _LoadText(path: Path, options: dict) -> Columns:
    """Columns that hold a number at all, NaN where they hold something else."""
    with in_file(path, CampaignError):
        lines = decode_lines(ReadBytes(path)).rstrip("\n").split("\n")
    lines = lines[options.get("skip_lines", 0) :]
    if len(lines) < 2:
        raise CampaignError(f"{path}: no rows below a header")
    default = "\t" if path.suffix == ".tsv" else ","
    delimiter = options.get("delimiter", default)
    try:
        every = csv.reader(lines, delimiter=delimiter)
        header = next(every)
        decimal = options.get("decimal", ".")
        rows = read_rows(filter(None, every), len(header), decimal)
    except (csv.Error, TypeError, ValueError) as error:
        raise CampaignError(f"{path}: not a table: {error}") from error
    wrong = np.flatnonzero(rows.widths != len(header))
    if wrong.size:
        raise CampaignError(
            f"{path}: row {wrong[0] + 1} has {rows.widths[wrong[0]]} fields,"
            f" the header {len(header)}"
        )
    return {
        name.strip(): column
        for name, column in zip(header, rows.values.T, strict=True)
        if not np.isnan(column).all()
    }


def _LoadMatlab(path: Path, options: dict) -> Columns:
    """Vectors, and columns of matrices, which count from 1 as in MATLAB."""
    with in_file(path, CampaignError):
        content = read_matlab(ReadBytes(path), options.get("group"))
    columns: Columns = {}
    for name, array in content.items():
        if array.ndim == 1 and array.size > 1:
            columns[name] = array
        elif array.ndim == 2:
            for i, column in enumerate(array.T, 1):
                columns[f"{name}({i})"] = column
    return columns


def _LoadTdms(path: Path, options: dict) -> Columns:
    """Channels, and `wf_time` where waveforms say their time themselves."""
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise CampaignError(
            f"{path}: TDMS needs npTDMS: pip install -e '.[lab]'"
        ) from error
    try:
        groups = {group.name: group for group in TdmsFile.read(path).groups()}
        columns = _take_channels(path, groups, options.get("group"))
    except CampaignError:
        raise
    # What a reader of another's format raises on a broken file is not foreseen.
    except Exception as error:
        raise CampaignError(
            f"{path}: not a TDMS file: {reason(error)}"
        ) from error
    return columns


def _take_channels(path: Path, groups: dict, wanted: str | None) -> Columns:
    if wanted is not None and wanted not in groups:
        raise CampaignError(
            f"{path}: no group {quoted(wanted)}; there are {', '.join(groups)}"
        )
    columns: Columns = {}
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
