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
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import CampaignError, reason
from brace_drake.core.output import WriteBytes
from brace_drake.recording.manifest import MANIFEST, parse_manifest
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording.table import Columns
from brace_drake.recording.write import describe

# Name of the metadata that holds a campaign, under the manifest's own name.
_CAMPAIGN = "brace_campaign"
_PROFILE, _ENCODING, _SCHEMA = "", "json", "jsonschema"
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
    writer.start(_PROFILE, "brace-drake")
    text = yaml.safe_dump(describe(campaign), sort_keys=False)
    writer.add_metadata(_CAMPAIGN, {MANIFEST: text})
    start = 0.0
    for run in campaign.runs:
        _AddRun(writer, run, start - float(run.time_s[0]))
        start += float(run.time_s[-1] - run.time_s[0]) + _PAUSE_S
    writer.finish()
    WriteBytes(Path(path), memory.getvalue())


def _AddRun(writer, run: Run, shift: float) -> None:
    names = tuple(run.channels)
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
    with _open_reader(path) as reader:
        texts = [
            m.metadata.get(MANIFEST, "")
            for m in reader.iter_metadata()
            if m.name == _CAMPAIGN
        ]
        if not texts:
            raise CampaignError(
                f"{path}: holds no campaign; take its topics by a map"
            )
        campaign, problems = parse_manifest(texts[-1].encode())
        errors = [p for p in problems if p.severity == "error"]
        if campaign is None or errors:
            raise CampaignError(f"{path}: {errors[0]}")
        tables = _read_topics(reader)
    runs = []
    for run in campaign.runs:
        topic = _topic(run.file)
        if "time_s" not in tables.get(topic, {}):
            raise CampaignError(f"{path}: no topic {topic} with time_s")
        channels = {n: v for n, v in tables[topic].items() if n != _LOG_TIME}
        runs.append(replace(run, channels=channels))
    return replace(campaign, path=path, runs=tuple(runs))


def LoadMcapTable(path: Path, options: dict) -> Columns:
    """Numbers of a topic's JSON messages as columns, each (N,).

    Fields within fields are named a.b, items of lists a[0]; `log_time_s` is
    the time of logging from the first message on. NaN where one is missing.

    Args:
        path: *.mcap.
        options: `group`, the topic; not needed where there is one alone.

    Raises:
        CampaignError: One line: file, and what is wrong with it.
    """
    with _open_reader(path) as reader:
        tables = _read_topics(reader)
    topic = options.get("group")
    if topic is None and len(tables) == 1:
        (topic,) = tables
    if topic not in tables:
        raise CampaignError(
            f"{path}: no topic {topic!r} of JSON messages; options.group may"
            f" be {', '.join(tables) or 'none, as there is none'}"
        )
    return tables[topic]


def _read_topics(reader) -> dict[str, Columns]:
    rows: dict[str, list[dict[str, float]]] = {}
    for _, channel, message in reader.iter_messages():
        if channel.message_encoding == _ENCODING:
            sample = dict(_flatten("", json.loads(message.data)))
            sample[_LOG_TIME] = 1e-9 * message.log_time
            rows.setdefault(channel.topic, []).append(sample)
    tables = {}
    for topic, samples in rows.items():
        names = dict.fromkeys(name for sample in samples for name in sample)
        table = {
            name: np.array([s.get(name, math.nan) for s in samples])
            for name in names
        }
        table[_LOG_TIME] = table[_LOG_TIME] - table[_LOG_TIME][0]
        tables[topic] = table
    return tables


def _flatten(name: str, value) -> Iterator[tuple[str, float]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _flatten(f"{name}.{key}" if name else str(key), item)
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from _flatten(f"{name}[{i}]", item)
    elif isinstance(value, int | float):
        yield name, float(value)


def _topic(file: str) -> str:
    return "/" + file.removesuffix(".csv")


@contextlib.contextmanager
def _open_reader(path: Path) -> Iterator:
    """A file's reader; whatever damaged bytes raise is one CampaignError."""
    make_reader = _Import("reader").make_reader
    try:
        with open(path, "rb") as file:
            yield make_reader(file, validate_crcs=True)
    except CampaignError:
        raise
    except Exception as error:
        why = reason(error) or type(error).__name__
        raise CampaignError(f"{path}: not an MCAP file: {why}") from error


def _Import(part: str):
    try:
        return importlib.import_module(f"mcap.{part}")
    except ImportError as error:
        raise CampaignError(
            "MCAP needs one more package: pip install -e '.[mcap]'"
        ) from error
