"""Columns of a file by name, whatever wrote it."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

from brace_drake.core.errors import CampaignError
from brace_drake.core.reading import ReadBytes, check_file, in_file
from brace_drake.recording.fields import TEXT, Field
from brace_drake.recording.importing.apart import read_apart
from brace_drake.recording.importing.dialect import guess_options
from brace_drake.recording.importing.formats.cells import Table
from brace_drake.recording.importing.formats.flatten import as_columns
from brace_drake.recording.importing.formats.json_rows import read_json
from brace_drake.recording.importing.formats.matlab import (
    is_version_7_3,
    read_matlab,
)
from brace_drake.recording.importing.formats.numpy_arrays import (
    read_npy,
    read_npz,
)
from brace_drake.recording.importing.formats.tdms import read_tdms
from brace_drake.recording.importing.formats.text import read_text
from brace_drake.recording.importing.mcap_file import (
    LoadMcapTable,
    has_json_messages,
)
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
# What a folder holds that is a bag of ROS 2.
_BAG = "metadata.yaml"


def LoadTable(path: str | Path, options: dict) -> Table:
    """Reads a file's columns, each (N,).

    Args:
        path: See `READERS`; or the folder of a ROS 2 bag.
        options: See `OPTIONS`. Of text: `delimiter` and `decimal`, guessed
            where nothing is said, `skip_lines`, also of Excel. `group` is the
            struct, group, sheet, key or topic to look in.

    Raises:
        CampaignError: One line: file, and what is wrong with it.
    """
    path = Path(path)
    # A name that no file can have is no folder either.
    is_bag = os.path.isfile(path / _BAG)
    ending = path.suffix.lower()
    reader = _BAG_READER if is_bag else READERS.get(ending)
    if reader is None:
        known = f"known are {', '.join(READERS)}, and folders of ROS 2 bags"
        raise CampaignError(f"{path}: {ending or 'no ending'}; {known}")
    with in_file(path, CampaignError):
        if not is_bag:
            check_file(path)
        columns = reader(path, options)
    table = Table(columns, advice=_ADVICE.get(reader, _WHERE))
    if not table:
        raise CampaignError(
            f"{path}: no column of numbers there; {table.advice}"
        )
    return table


def _read_text(path: Path, options: dict) -> Columns:
    if not options.keys() & {"delimiter", "decimal", "skip_lines"}:
        guessed = guess_options(path)
        options = {k: v for k, v in guessed.items() if k != "skip_lines"}
    default = "\t" if path.suffix == ".tsv" else ","
    return read_text(
        path,
        options.get("delimiter", default),
        options.get("decimal", "."),
        options.get("skip_lines", 0),
    )


def _read_matlab(path: Path, options: dict) -> Columns:
    data, group = ReadBytes(path), options.get("group")
    if is_version_7_3(data):
        return read_apart("hdf5", path, group)
    found = read_matlab(data, group)
    return Table(as_columns(found), found.words)


def _read_mcap(path: Path, options: dict) -> Columns:
    if has_json_messages(path):
        return LoadMcapTable(path, options)
    return _BAG_READER(path, options)


def _read_excel(path: Path, options: dict) -> Columns:
    skipped = options.get("skip_lines", 0)
    return read_apart("excel", path, options.get("group"), skipped)


def _grouped(reader: Callable[..., Columns]) -> Callable[..., Columns]:
    return lambda path, options: reader(path, options.get("group"))


_BAG_READER = _grouped(partial(read_apart, "ros bag"))
READERS: dict[str, Callable[..., Columns]] = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat"), _read_text),
    ".mat": _read_matlab,
    ".tdms": _grouped(read_tdms),
    ".mcap": _read_mcap,
    **dict.fromkeys((".json", ".jsonl", ".ndjson"), _grouped(read_json)),
    ".npz": _grouped(read_npz),
    ".npy": _grouped(read_npy),
    **dict.fromkeys((".h5", ".hdf5"), _grouped(partial(read_apart, "hdf5"))),
    **dict.fromkeys((".xlsx", ".xlsm"), _read_excel),
    **dict.fromkeys((".db3", ".bag"), _BAG_READER),
}
# What helps where a file has not the columns that it should have.
_WHERE = "options.group says where in the file to look"
_ADVICE = {
    _read_text: "options.delimiter and options.decimal say how numbers are"
    " written, options.skip_lines how many lines come before the names",
    _read_excel: "options.skip_lines says how many rows come before the names,"
    " options.group which sheet it is",
}
