"""MCAP, the container of robot recordings (mcap.dev): in and out.

A campaign becomes one file: campaign.yaml as metadata, each run a topic of JSON
messages, one a sample, with time and channels by name in SI units. Runs follow
each other with a second between them, so that a viewer shows one at a time. A
value that is not a number is left out of its message.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import json
import math
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from brace_drake.core.errors import CampaignError, ReadError, quoted, reason
from brace_drake.core.output import WriteBytes
from brace_drake.core.reading import ReadBytes, decode, parse_json
from brace_drake.core.reading.files import LARGEST, most_bytes
from brace_drake.recording.importing.formats.cells import (
    Samples,
    Table,
)
from brace_drake.recording.importing.formats.flatten import (
    cells_of,
    check_room,
)
from brace_drake.recording.importing.rules import check_columns
from brace_drake.recording.manifest import MANIFEST, parse_manifest
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording.write import describe

# Name of the metadata that holds a campaign, under the manifest's own name.
_CAMPAIGN = "brace_campaign"
_SCENARIO = "scenario"
_PROFILE, _ENCODING, _SCHEMA = "", "json", "jsonschema"
_WRITER = "brace-drake"
# How files of `WriteMcap` begin: the format's mark, and a header with a profile
# and a writer.
START = b"\x89MCAP0\r\n\x01" + struct.pack(
    f"<QII{len(_WRITER)}s", 8 + len(_WRITER), 0, len(_WRITER), _WRITER.encode()
)
_LOG_TIME = "log_time_s"
_PAUSE_S = 1.0


def WriteMcap(campaign: Campaign, path: str | Path) -> None:
    """Writes a campaign as one MCAP file.

    Raises:
        CampaignError: The package mcap is not installed.
        OutputError: The file cannot be written.
    """
    memory = io.BytesIO()
    writer = _Import("writer").Writer(memory)
    writer.start(_PROFILE, _WRITER)
    text = yaml.safe_dump(describe(campaign), sort_keys=False)
    kept = {MANIFEST: text}
    if campaign.scenario is not None:
        kept[_SCENARIO] = decode(campaign.scenario.data)
    writer.add_metadata(_CAMPAIGN, kept)
    start = 0.0
    for run in campaign.runs:
        _AddRun(writer, run, start - float(run.time_s[0]))
        start += float(run.time_s[-1] - run.time_s[0]) + _PAUSE_S
    writer.finish()
    WriteBytes(Path(path), memory.getvalue())


def _AddRun(writer, run: Run, shift: float) -> None:
    # Columns of remarks are none of numbers.
    names = tuple(n for n, v in run.channels.items() if v.dtype.kind in "fiub")
    schema = {
        "type": "object",
        "properties": {name: {"type": "number"} for name in names},
    }
    number = writer.register_schema(
        run.name, _SCHEMA, json.dumps(schema).encode()
    )
    channel = writer.register_channel(_topic(run.file), _ENCODING, number)
    columns = [np.asarray(run.channels[n], float).tolist() for n in names]
    for i, row in enumerate(zip(*columns, strict=True)):
        sample = dict(zip(names, row, strict=True))
        sample = {n: v for n, v in sample.items() if math.isfinite(v)}
        when = round(1e9 * (sample["time_s"] + shift))
        writer.add_message(channel, when, json.dumps(sample).encode(), when, i)


def LoadMcapCampaign(path: str | Path) -> Campaign:
    """Reads a campaign that `WriteMcap` has written.

    Raises:
        CampaignError: One line: file, and what is wrong with it.
    """
    path = Path(path)
    with _reading(path):
        tables, metadata = _read_all(ReadBytes(path))
        if _CAMPAIGN not in metadata:
            raise CampaignError(
                f"{path}: holds no campaign; take its topics by a map"
            )
        text = metadata[_CAMPAIGN].get(MANIFEST, "")
        campaign, problems = parse_manifest(text.encode())
        errors = [p for p in problems if p.severity == "error"]
        if campaign is None or errors:
            raise CampaignError(f"{path}: {errors[0]}")
    runs = []
    for run in campaign.runs:
        topic = _topic(run.file)
        table = tables.get(topic, Table({}))
        if "time_s" not in {*table, *table.words}:
            raise CampaignError(f"{path}: no topic {topic} with time_s")
        known = {"time_s", *campaign.known_channels} & table.words.keys()
        check_columns(f"{path}: topic {topic}", table, sorted(known))
        channels = {n: v for n, v in table.items() if n != _LOG_TIME}
        runs.append(replace(run, channels=channels))
    scenario = campaign.scenario
    if scenario is not None:
        if _SCENARIO not in metadata[_CAMPAIGN]:
            raise CampaignError(
                f"{path}: scenario {scenario.name} is not there"
            )
        data = metadata[_CAMPAIGN][_SCENARIO].encode()
        scenario = replace(scenario, data=data)
    return replace(campaign, path=path, runs=tuple(runs), scenario=scenario)


def LoadMcapTable(path: Path, options: dict) -> Table:
    """Numbers of a topic's JSON messages as columns, each (N,).

    Fields within fields are named a.b, items of lists a[0]; `log_time_s` is
    the time of logging from the first message on. NaN where one is missing.

    Args:
        path: *.mcap.
        options: `group`, the topic; not needed where there is one alone.

    Raises:
        CampaignError: One line: file, and what is wrong with it.
    """
    with _reading(path):
        tables, _ = _read_all(ReadBytes(path))
    topic = options.get("group")
    if topic is None and len(tables) == 1:
        (topic,) = tables
    if topic not in tables:
        raise CampaignError(
            f"{path}: no topic {quoted(topic)} of JSON messages; options.group"
            f" may be {', '.join(tables) or 'none, as there is none'}"
        )
    return tables[topic]


def has_json_messages(path: Path) -> bool:
    """Whether a file has topics of JSON messages, or none at all.

    Raises:
        CampaignError: One line: file, and what is wrong with it.
    """
    has_topics = False
    with _reading(path):
        for record in _records(ReadBytes(path)):
            if type(record).__name__ == "Channel":
                has_topics = True
                if record.message_encoding == _ENCODING:
                    return True
    return not has_topics


def _by_time(table: Table) -> Table:
    """A topic's columns in the order of logging, their time from 0."""
    times = table[_LOG_TIME]
    order = np.argsort(times, kind="stable")
    rows = np.argsort(order) + 1
    columns = {name: values[order] for name, values in table.items()}
    columns[_LOG_TIME] = columns[_LOG_TIME] - times[order[0]]
    words = {
        name: word._replace(row=int(rows[word.row - 1]))
        for name, word in table.words.items()
    }
    return Table(columns, words)


def _read_all(data: bytes) -> tuple[dict[str, Table], dict[str, dict]]:
    """Tables of all topics of JSON messages, and metadata by name."""
    topics: dict[str, Samples] = {}
    channels, metadata, cells = {}, {}, 0
    for record in _records(data):
        kind = type(record).__name__
        if kind == "Channel":
            channels[record.id] = record
        elif kind == "Metadata":
            metadata[record.name] = record.metadata
        elif kind == "Message":
            channel = channels[record.channel_id]
            if channel.message_encoding == _ENCODING:
                value = parse_json(record.data, may_be_nan=True)
                sample = cells_of(value)
                sample[_LOG_TIME] = 1e-9 * record.log_time
                samples = topics.setdefault(channel.topic, Samples())
                cells -= samples.size
                samples.add(sample)
                cells += samples.size
                # Topics that all go far share the memory.
                check_room(cells)
    tables = {name: _by_time(topic.table()) for name, topic in topics.items()}
    return tables, metadata


def _records(data: bytes) -> Iterator[Any]:
    """All records, those of chunks within bounds of memory."""
    reader = _Import("stream_reader")
    left = most_bytes(LARGEST)
    for record in reader.StreamReader(
        io.BytesIO(data),
        emit_chunks=True,
        validate_crcs=True,
        record_size_limit=len(data),
    ).records:
        if type(record).__name__ != "Chunk":
            yield record
            continue
        left -= record.uncompressed_size
        if left < 0:
            raise ReadError("unpacks to more than memory is meant for")
        raw = _unpack(record)
        if len(raw) != record.uncompressed_size:
            raise ReadError("a chunk has not the size that it says")
        plain = replace(record, compression="", data=raw)
        yield from reader.breakup_chunk(plain, validate_crc=True)


def _unpack(chunk) -> bytes:
    """A chunk's records, and no more of them than one byte too many."""
    most = chunk.uncompressed_size + 1
    if chunk.compression == "zstd":
        import zstandard

        with zstandard.ZstdDecompressor().stream_reader(chunk.data) as stream:
            return stream.read(most)
    if chunk.compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor

        return LZ4FrameDecompressor().decompress(chunk.data, most)
    if chunk.compression:
        raise ReadError(f"packed by {quoted(chunk.compression)}")
    return chunk.data


def _topic(file: str) -> str:
    return "/" + file.removesuffix(".csv")


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Whatever damaged bytes raise is one CampaignError."""
    try:
        yield
    except CampaignError:
        raise
    except ReadError as error:
        raise CampaignError(f"{path}: {error}") from error
    except Exception as error:
        raise CampaignError(
            f"{path}: not an MCAP file: {reason(error)}"
        ) from error


def _Import(part: str):
    try:
        return importlib.import_module(f"mcap.{part}")
    except ImportError as error:
        raise CampaignError(
            "MCAP needs one more package: pip install -e '.[mcap]'"
        ) from error
