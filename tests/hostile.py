"""Well-formed files that no one would write: strategies for each format.

Each starts from sound files of a reader of `reader_fuzz` and from what its
format declares, and puts in their place what readers may stumble over.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from scipy.io import savemat

from tests.reader_fuzz import READERS, Bench, Reader

try:
    from mcap.writer import CompressionType, Writer
except ImportError:
    Writer = None


class Raw(str):
    """YAML or JSON that is written as it is."""


class Sound(str):
    """A sound file's text, which no message shows."""

    def __repr__(self) -> str:
        return "..."


class Hostile(NamedTuple):
    """A reader, one of its files, and a strategy of bytes for that."""

    reader: Reader
    file: str
    contents: Callable[[Path], st.SearchStrategy[bytes]]


NUMBERS = st.one_of(
    st.sampled_from(
        [0, -0.0, 1, -1, 1e-320, 5e-324, 1e308, -1e308, 1e20, 2**63, -(2**31)]
    ),
    st.sampled_from([math.nan, math.inf, -math.inf, 1e-12, 3, 6, 1000000]),
    st.floats(),
    st.integers(-5, 100),
)
WORDS = st.one_of(
    st.sampled_from(
        [
            *("", " ", "x", "x" * 3000, "\u202e", "é", "a\nb", "a\tb"),
            "\x7f",
            *("../../etc/passwd", "/dev/zero", "bench stage 2", "brace", "NaN"),
            *(
                "validation",
                "fit",
                "time_s",
                "campaign.yaml",
                "push.csv",
                "1e3",
            ),
        ]
    ),
    st.text(max_size=6),
)
TOKENS = st.sampled_from(
    [
        *("9" * 400, "0x" + "f" * 400, "0b1", "0o7", "012", "1:30:00", "1_0"),
        *(
            "2024-99-99",
            "2001-12-14t21:59:43.10-05:00",
            ".inf",
            "-.INF",
            ".nan",
        ),
        *("1.0e+999", "1e-999", "yes", "~", "!!int 3", "!!float x", "!x 1"),
        *("!!python/object/apply:os.system [x]", "!!binary AAAA", "&a [1, 2]"),
        *("*a", "&b [*b]", "{<<: *a}", "{<<: {x: 1}}", "? [a]", "<<", "=", "%"),
        *('"\\e[31m"', '"\\ud800"', '"\\0"', "'", "[" * 60, "{a: " * 60),
        "[&l [x,x,x,x,x,x,x,x], &m [*l,*l,*l,*l,*l,*l,*l,*l], &n"
        " [*m,*m,*m,*m,*m,*m,*m,*m], [*n,*n,*n,*n,*n,*n,*n,*n]]",
        "[" + "1, " * 3000 + "1]",
        "{" + ", ".join(f"k{i}: {i}" for i in range(1500)) + "}",
    ]
).map(Raw)
VALUES = st.recursive(
    st.one_of(NUMBERS, WORDS, TOKENS, st.booleans(), st.none()),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(WORDS, inner, max_size=3)
    ),
    max_leaves=5,
)


def flow(value: object) -> str:
    """A tree as YAML in its flow style, which mostly is JSON."""
    if isinstance(value, Raw):
        return str(value)
    if isinstance(value, dict):
        items = (f"{flow(k)}: {flow(v)}" for k, v in value.items())
        return "{" + ", ".join(items) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}[repr(value)]
    return json.dumps(value)


def _places(tree: object) -> list[tuple]:
    found: list[tuple] = []
    level = [tree]
    while level:
        node = level.pop()
        if isinstance(node, dict | list):
            keys = node if isinstance(node, dict) else range(len(node))
            for key in list(keys):
                found.append((node, key))
                level.append(node[key])
    return found


@st.composite
def yaml_files(draw, text: str) -> bytes:
    """A map as it should be, but for a few values, keys and items."""
    tree = yaml.safe_load(text)
    for _ in range(draw(st.integers(1, 4))):
        node, key = draw(st.sampled_from(_places(tree)))
        match draw(st.integers(0, 5)):
            case 0 if isinstance(node, dict):
                node[draw(WORDS | TOKENS)] = draw(VALUES)
            case 1 if isinstance(node, list):
                node += [node[key]] * draw(st.sampled_from([1, 2, 300]))
            case 2 if isinstance(node, dict):
                node[draw(TOKENS | WORDS)] = node.pop(key)
            case _:
                node[key] = draw(VALUES)
        if not _places(tree):
            break
    return flow(tree).encode("utf-8", "replace")


FIELDS = st.one_of(
    NUMBERS.map(repr),
    st.sampled_from(["", " ", "nan", "1e999", "0x1p3", "1_0", "x" * 2000, '"']),
    st.sampled_from(["9" * 400, "1,5", "1;2", "é", "\u202e", "\x1b[31m", "-"]),
)


@st.composite
def tables(draw, text: str, delimiter: str = ",") -> bytes:
    """A table as it should be, but for some columns, rows and fields."""
    header, *rows = [line.split(delimiter) for line in text.splitlines()]
    rows = rows[: draw(st.sampled_from([0, 1, 2, 3, 9, 10, 11, 60, 10**6]))]
    for _ in range(draw(st.integers(1, 3))):
        column = draw(st.integers(0, len(header) - 1))
        if draw(st.booleans()):
            column = 0
        at = draw(st.integers(0, max(len(rows) - 1, 0)))
        field = draw(FIELDS)
        match draw(st.integers(0, 9)):
            case 0 | 1:
                end = at + draw(st.sampled_from([1, 7, 10**6]))
                _change(rows[at:end], column, lambda _, f=field: f)
            case 2:
                factor = draw(st.sampled_from([-1, 0, 1e-320, 1e9, 1e300]))
                _change(rows, column, lambda v, f=factor: repr(_float(v) * f))
            case 3:
                jump = draw(st.sampled_from([1e-9, 1.0, 9e4, 1e9, 1e308]))
                _change(
                    rows[at:], column, lambda v, j=jump: repr(_float(v) + j)
                )
            case 4:
                header[column] = draw(st.sampled_from(header) | FIELDS)
            case 5:
                count = draw(st.sampled_from([1, 500]))
                for line in (header, *rows):
                    line += [field] * count
            case 6:
                rows.insert(at, [field] * draw(st.integers(0, 40)))
            case 7:
                for row in rows:
                    del row[column : column + 1]
                del header[column]
                if not header:
                    break
            case 8:
                rows[at:at] = rows[at : at + 9] * draw(st.integers(1, 3))
            case 9:
                rows.reverse()
    lines = [delimiter.join(line) for line in (header, *rows)]
    end = draw(st.sampled_from(["\n", "\r\n", "\r", "\n\n"]))
    text = end.join(lines) + end * draw(st.integers(0, 1))
    return text.encode("utf-8", "replace")


def _change(
    rows: list[list[str]], column: int, change: Callable[[str], str]
) -> None:
    for row in rows:
        if column < len(row):
            row[column] = change(row[column])


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return 1.0


@st.composite
def arrays(draw) -> object:
    """An array of any kind and shape, numpy's or MATLAB's."""
    shape = draw(
        st.sampled_from(
            [(), (0,), (1,), (2,), (6,), (7,), (18,), (4, 7), (1, 7), (7, 1)]
        )
        | st.lists(st.integers(0, 4), max_size=4).map(tuple)
    )
    kind = draw(st.sampled_from(["f8", "f4", "i8", "u1", "?", "c16", "U3"]))
    if kind == "U3":
        return np.full(shape, draw(st.text(max_size=3)), dtype=kind)
    value = draw(NUMBERS)
    with np.errstate(all="ignore"):
        return np.full(shape, value, dtype=float).astype(kind)


@st.composite
def policies(draw, sound: dict[str, np.ndarray]) -> bytes:
    """A policy with some of its arrays gone, others or changed."""
    found = dict(sound)
    for _ in range(draw(st.integers(1, 3))):
        name = draw(st.sampled_from(sorted(found)))
        match draw(st.integers(0, 5)):
            case 0:
                del found[name]
            case 1 if found[name].dtype.kind == "f":
                with np.errstate(all="ignore"):
                    found[name] = found[name] * draw(NUMBERS)
            case 2:
                found[name] = found[draw(st.sampled_from(sorted(found)))]
            case 3 if found[name].ndim:
                found[name] = found[name][:-1]
            case 4:
                found["task"] = np.array(draw(yaml_files(str(sound["task"]))))
                found["task"] = np.array(bytes(found["task"]).decode())
            case _:
                found[name] = draw(arrays())
    memory = io.BytesIO()
    np.savez(memory, **found)
    return memory.getvalue()


@st.composite
def matlab_files(draw, _) -> bytes:
    """Variables, structs and cells that may be what the map asks for."""
    t = np.arange(40) / 40.0
    content = {"t": t, "y": np.sin(t), "f": np.cos(t)}
    anything = st.recursive(
        arrays(),
        lambda inner: st.dictionaries(
            st.sampled_from(["t", "y", "f", "s"]), inner, max_size=3
        ),
        max_leaves=4,
    )
    for _ in range(draw(st.integers(1, 3))):
        name = draw(st.sampled_from(["t", "y", "f", "s"]))
        match draw(st.integers(0, 3)):
            case 0:
                kind = [("t", object), ("y", float)]
                shape = draw(st.sampled_from([(), (2,), (2, 2), (0,)]))
                content[name] = np.zeros(shape, kind)
                content[name]["t"] = 0.5
            case 1:
                items = draw(st.lists(arrays(), max_size=3))
                content[name] = np.empty(len(items), object)
                for i, item in enumerate(items):
                    content[name][i] = item
            case 2:
                with np.errstate(all="ignore"):
                    content[name] = t * draw(NUMBERS)
            case _:
                content[name] = draw(anything)
    memory = io.BytesIO()
    packed = draw(st.booleans())
    try:
        with np.errstate(all="ignore"):
            savemat(memory, content, do_compression=packed)
    except (TypeError, ValueError):
        return b"MATLAB 5.0"
    data = bytearray(memory.getvalue())
    for _ in range(draw(st.integers(0, 2))):
        at = draw(st.integers(124, len(data) - 4)) // 4 * 4
        data[at : at + 4] = draw(
            st.sampled_from([b"\0\0\0\0", b"\xff\xff\xff\x7f", b"\1\0\0\0"])
            | st.binary(min_size=4, max_size=4)
        )
    cut = draw(st.sampled_from([None, None, 0.5, 0.9]))
    return bytes(data[: None if cut is None else int(cut * len(data))])


@st.composite
def mcap_files(draw, manifest: str) -> bytes:
    """Messages and a manifest that are JSON and YAML, and not as asked for."""
    memory = io.BytesIO()
    packed = draw(st.sampled_from(list(CompressionType)))
    writer = Writer(memory, compression=packed)
    writer.start("", "x")
    text = draw(st.just(manifest.encode()) | yaml_files(manifest)).decode()
    if draw(st.integers(0, 4)):
        writer.add_metadata("brace_campaign", {"campaign.yaml": text})
    schema = writer.register_schema("x", "jsonschema", b"{}")
    for topic in draw(st.lists(st.sampled_from(["/first", "/x", "/\x1b"]),
                               max_size=2)):  # fmt: skip
        channel = writer.register_channel(topic, "json", schema)
        for i in range(draw(st.sampled_from([0, 1, 2, 30]))):
            sample = {"time_s": 0.01 * i, "displacement_m": 0.0, "force_N": 1.0}
            if draw(st.integers(0, 9)) == 0:
                sample[draw(WORDS)] = draw(VALUES)
            data = flow(sample).encode("utf-8", "replace")
            when = draw(st.sampled_from([i * 10**7, 0, 2**63]))
            writer.add_message(channel, when, data, when)
    writer.finish()
    data = memory.getvalue()
    cut = draw(st.sampled_from([None, None, None, 0.5, 0.9]))
    return data[: None if cut is None else int(cut * len(data))]


MAP = """format: brace-import/1
device: pad bench
columns: {time_s: t, displacement_m: y, force_N: {from: f, scale: 2.0}}
runs:
- {file: x.mat, motion: push, split: fit}
"""
MCAP_MANIFEST = """format: brace-campaign/1
device: pad bench
rate_hz: 100.0
subject: x
runs:
- {file: first.csv, contact: true, motion: push, split: fit}
- {file: x.csv, contact: true, motion: push, split: validation}
"""


def _write_matlab(folder: Path) -> None:
    (folder / "map.yaml").write_text(MAP)
    t = np.arange(40) / 40.0
    savemat(folder / "x.mat", {"t": t, "y": np.sin(t), "f": np.cos(t)})


def _read_map(folder: Path) -> object:
    from brace_drake.recording.importing.mapped import ImportCampaign

    return ImportCampaign(folder / "map.yaml")


def _write_mcap(folder: Path) -> None:
    with (folder / "x.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start("", "x")
        writer.add_metadata("brace_campaign", {"campaign.yaml": MCAP_MANIFEST})
        schema = writer.register_schema("x", "jsonschema", b"{}")
        for topic in ("/first", "/x"):
            channel = writer.register_channel(topic, "json", schema)
            writer.add_message(channel, 0, b'{"time_s": 0}', 0)
        writer.finish()


def _read_mcap(folder: Path) -> object:
    from brace_drake.recording.importing import LoadMcapCampaign

    return LoadMcapCampaign(folder / "x.mcap")


def _text_of(strategy, file: str, **options):
    return lambda sound: strategy(Sound((sound / file).read_text()), **options)


def _policy(sound: Path) -> st.SearchStrategy[bytes]:
    with np.load(sound / "policy.npz") as file:
        return policies(dict(file))


@cache
def formats() -> dict[str, Hostile]:
    """All, by name."""
    known = {reader.name: reader for reader in READERS}
    matlab = Reader("matlab", _write_matlab, _read_map, ())
    found = {
        "run": Hostile(
            known["campaign"], "push.csv", _text_of(tables, "push.csv")
        ),
        "policy": Hostile(known["policy"], "policy.npz", _policy),
        "table of a lab": Hostile(
            known["import"],
            "first.csv",
            _text_of(tables, "first.csv", delimiter=";"),
        ),
        "matlab": Hostile(matlab, "x.mat", matlab_files),
        "reference": Hostile(
            known["reference"],
            "paper_push.csv",
            _text_of(tables, "paper_push.csv"),
        ),
    }
    for name, file in (
        ("campaign", "campaign.yaml"),
        ("import", "map.yaml"),
        ("plan", "plan.yaml"),
        ("limits", "limits.yaml"),
        ("measures", "torso_girl13.measures.yaml"),
        ("scenario bench", "bench.scenario.yaml"),
        ("scenario brace", "brace.scenario.yaml"),
        ("scenario pad_bench", "pad_bench.scenario.yaml"),
    ):
        text = _text_of(yaml_files, file)
        found[f"{name} yaml"] = Hostile(known[name], file, text)
    if Writer is not None:
        mcap = Reader("mcap", _write_mcap, _read_mcap, ())
        found["mcap"] = Hostile(
            mcap, "x.mcap", lambda _: mcap_files(MCAP_MANIFEST)
        )
    return found


def try_format(
    name: str, number: int, chosen: int, told: Callable[[bytes, str], None]
) -> None:
    """Reads so many files of a format; the same ones for the same seed.

    Args:
        name: Of the format.
        number: Of files.
        chosen: The seed.
        told: Called with each file, and with what went wrong or nothing.
    """
    hostile = formats()[name]
    bench = Bench(hostile.reader)

    @seed(chosen)
    @settings(
        max_examples=number,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(hostile.contents(bench.sound))
    def read(data: bytes) -> None:
        told(data, bench.try_file(hostile.file, data) or "")

    try:
        read()
    finally:
        bench.close()
