"""Policies, and a lab's own files, that were made to break their reader."""

import io
import json
import math
import struct
import tempfile
import unittest
import warnings
import zipfile
import zlib
from pathlib import Path

import numpy as np
from scipy.io import savemat

from brace_drake.core.errors import BraceError, CampaignError, PolicyError
from brace_drake.learning.policy import LoadPolicy, SavePolicy
from brace_drake.recording.importing.mapped import ImportCampaign
from tests.learning_tasks import random_policy
from tests.reader_fuzz import time_limit
from tests.test_reading import LAUGHS

try:
    from mcap.writer import CompressionType, Writer
except ImportError:
    Writer = None


class HostileTest(unittest.TestCase):
    error: type[BraceError] = CampaignError

    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def assert_refused(self, read, path, *words):
        with (
            self.assertRaises(self.error) as caught,
            time_limit(5.0),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("error")
            read(path)
        message = str(caught.exception)
        self.assertTrue(message.isprintable(), message)
        self.assertLess(len(message), 500)
        for word in words:
            self.assertIn(word, message)


class TestPolicies(HostileTest):
    error = PolicyError

    def setUp(self):
        super().setUp()
        self.path = self.folder / "policy.npz"
        SavePolicy(random_policy(hidden=4), self.path)
        with np.load(self.path) as file:
            self.arrays = dict(file)

    def refuse(self, *words, **changes):
        arrays = self.arrays | changes
        kept = {n: a for n, a in arrays.items() if a is not None}
        np.savez(self.path, **kept)
        self.assert_refused(LoadPolicy, self.path, "policy.npz", *words)

    def test_shapes_and_kinds(self):
        mean, text = self.arrays["mean"], np.array(["x"] * 7)
        for name in ("mean", "gain", "W0", "b1", "law_start"):
            found = self.arrays[name]
            for bad in (
                *(np.array(1.0), found[None], found[..., :-1], found[:0]),
                *(found.astype(str), found * math.nan, found + math.inf),
                *(found.astype(complex), found.astype(float) * 0 + 1e300, None),
            ):
                with self.subTest(name=name, bad=bad):
                    self.refuse(**{name: bad})
        self.refuse("mean", mean=mean.reshape(1, -1))
        self.refuse("gain", gain=text)

    def test_layers(self):
        layers = {n: None for n in self.arrays if n[0] in "Wb" and n[1:] < "9"}
        self.refuse("no layer", **layers)
        self.refuse("outputs", W2=None, b2=None)
        self.refuse("layer 0", W0=np.zeros((4, 3)))
        self.refuse("W0", W0=np.zeros((0, 7)), b0=np.zeros(0))
        self.refuse("b0", b0=None)

    def test_law_and_the_rest(self):
        for name, values in (
            ("law_lower", (math.nan, -1.0, 0.0, math.inf, 1e300)),
            ("law_upper", (math.nan, -1.0, 1.0, math.inf)),
            ("law_largest", (math.nan, -0.1, 0.0, math.inf)),
            ("law_start", ([math.nan], [-1.0], [1e9], [[1.0]])),
            ("law_scale", ("cube", 3, ["log"])),
            ("clip", (math.nan, 0.0, -1.0, [1.0], "x")),
            ("format", (2, [1], "x", math.nan)),
            ("selected", ([True], [0, 1], [False] * 6, True, [True] * 7, "x")),
            ("task", ("[", "scenario: [", LAUGHS, "observation: none", 3)),
            (
                "task",
                (
                    "sample_time: .nan",
                    "max_steps: -1",
                    "max_steps: 1000000",
                    "sample_time: 1000.0",
                    "x: 1",
                ),
            ),
            ("task", ("displacement: [1, 2]", "displacement: [.nan]")),
        ):
            for value in values:
                with self.subTest(name=name, value=value):
                    self.refuse(**{name: np.array(value)})

    def test_archives(self):
        bad = np.array([print, None], dtype=object)
        self.refuse("is not a policy", mean=bad)
        for names, data in (
            (["mean.npy"] * 2, b""),
            ([f"a{i}.npy" for i in range(200)], b""),
            (["mean.npy"], b"\x93NUMPY\x01\x00"),
        ):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                with zipfile.ZipFile(self.path, "w") as archive:
                    for name in names:
                        archive.writestr(name, data)
            self.assert_refused(LoadPolicy, self.path, "is not a policy")
        head = io.BytesIO()
        shape = {"descr": "<f8", "fortran_order": False, "shape": (10**10,)}
        np.lib.format.write_array_header_1_0(head, shape)
        for data in (head.getvalue(), head.getvalue() + bytes(200_000_000)):
            with zipfile.ZipFile(
                self.path, "w", zipfile.ZIP_DEFLATED
            ) as archive:
                archive.writestr("mean.npy", data)
            self.assert_refused(LoadPolicy, self.path, "is not a policy")
        self.assert_refused(LoadPolicy, "/dev/zero", "is a device")
        self.assert_refused(LoadPolicy, self.folder, "is a folder")


class ImportTest(HostileTest):
    def write_map(self, file="x.mat", more="", run="", columns=None):
        columns = columns or {"displacement_m": "y", "force_N": "f"}
        columns = {"time_s": "t", **columns}
        (self.folder / "map.yaml").write_text(
            "format: brace-import/1\ndevice: pad bench\n"
            f"columns: {json.dumps(columns)}\n{more}\n"
            f"runs:\n- {{file: {file}{run}}}\n"
        )
        return self.folder / "map.yaml"

    def refuse(self, *words, **options):
        self.assert_refused(ImportCampaign, self.write_map(**options), *words)


class TestMatlab(ImportTest):
    def setUp(self):
        super().setUp()
        t = np.arange(100) / 100.0
        self.channels = {"t": t, "y": np.sin(t), "f": np.cos(t)}
        self.path = self.folder / "x.mat"
        savemat(self.path, self.channels)

    def test_structs(self):
        kind = [("t", float), ("y", object)]
        group = "options: {group: s}"
        for value, word in (
            (np.zeros(2, kind), "array of 2 structs"),
            (np.zeros((2, 2), kind), "array of 4 structs"),
            (3.0, "no struct"),
            ("text", "no struct"),
            (np.array([1, "x"], dtype=object), "no struct"),
            ({"t": {"deep": 1}, "y": [[1, 2], [3, 4]]}, "no column 't'"),
        ):
            savemat(self.path, {"s": value})
            self.refuse(word, more=group)

    def test_every_kind_of_numbers_in_every_version(self):
        for kind in ("f4", "i1", "u1", "i4", "i8", "u8", "?"):
            y = np.arange(100).astype(kind)
            for options in ({}, {"do_compression": True}, {"format": "4"}):
                if options.get("format") == "4" and kind in ("i8", "u8", "i1"):
                    continue
                savemat(self.path, self.channels | {"y": y}, **options)
                (run,) = ImportCampaign(self.write_map()).runs
                found = run.channels["displacement_m"]
                np.testing.assert_array_equal(found, y.astype(float))
        group = {"s": {**self.channels, "m": np.eye(100), "w": "text"}}
        savemat(self.path, group | {"cell": np.array([1, "x"], object)})
        more = "options: {group: s}"
        columns = {"displacement_m": "y", "force_N": "m(3)"}
        (run,) = ImportCampaign(self.write_map(more=more, columns=columns)).runs
        np.testing.assert_array_equal(run.channels["force_N"], np.eye(100)[2])

    def test_cut_and_torn_files(self):
        for compressed in (False, True):
            savemat(self.path, self.channels, do_compression=compressed)
            data = self.path.read_bytes()
            for at in (*range(0, 300, 7), len(data) // 2, len(data) - 9):
                self.path.write_bytes(data[:at])
                self.refuse()
        self.path.write_bytes(data[:128] + b"\xff" * 200)
        self.refuse()

    def test_sizes_that_are_not_there(self):
        def element(kind, data):
            pad = b"\0" * (-len(data) % 8)
            return struct.pack("<II", kind, len(data)) + data + pad

        def matrix(kind, *sizes, content=b""):
            return element(
                14,
                element(6, struct.pack("<II", kind, 0))
                + element(5, struct.pack(f"<{len(sizes)}i", *sizes))
                + element(1, b"s")
                + content,
            )

        head = self.path.read_bytes()[:128]
        deep, number = b"", element(9, bytes(8))
        for _ in range(60):
            deep = matrix(1, 1, 1, content=deep)
        for body, word in (
            (matrix(1, 2**30, 2**30), "no column"),
            (matrix(2, 2**31 - 1, 4), "structs"),
            (matrix(1, 1, 1, content=matrix(1, 2**30, 1)), "no column"),
            (matrix(6, 2**30, 2**30, content=number), "not the size"),
            (matrix(6, -1, -1, content=number), "not the size"),
            (matrix(2, 1, 1, content=matrix(6, 9, 9)), "no column"),
            (deep, "no column"),
            (matrix(2, 1, 1, content=element(5, b"") * 2), "no column"),
            (bytes(300_000_000), "more than memory"),
        ):
            packed = zlib.compress(body)
            tag = struct.pack("<II", 15, len(packed))
            self.path.write_bytes(head + tag + packed)
            self.refuse(word)

    def test_numbers_of_the_map(self):
        columns = {"displacement_m": "y", "force_N": {"from": "f"}}
        for more in ("rate_hz: 1e300", "rate_hz: 1.0e+300", "rate_hz: 0.0"):
            self.refuse("rate_hz", more=more)
        for more in ("settled_s: 1.0e+300", f"settled_s: {'9' * 400}"):
            self.refuse("settled_s", more=more)
        for key in ("scale", "offset"):
            for value in (1e300, 10**30, math.inf):
                columns["force_N"] = {"from": "f", key: value}
                self.refuse("force_N", columns=columns)
        for rule in ({"from": None}, {"constant": None}, {}, None, [], True):
            columns["force_N"] = rule
            self.refuse("columns.force_N must be", columns=columns)
        columns["force_N"] = 3
        self.refuse("no column '3'", columns=columns)
        columns["force_N"] = {"from": "f", "scale": 1e12}
        savemat(self.path, self.channels | {"f": np.full(100, 1e300)})
        self.refuse("row 1", "force_N", columns=columns)

    def test_times_of_the_file(self):
        t = self.channels["t"]
        for bad in (
            *(np.where(t == t[5], v, t) for v in (math.inf, math.nan, 1e308)),
            *(-t, t * 0, t * 1e-320),
        ):
            savemat(self.path, self.channels | {"t": bad})
            self.refuse("row", "time_s")
        jump = np.where(t > 0.5, t + 1e11, t)
        savemat(self.path, self.channels | {"t": jump})
        self.refuse("the time jumps", more="rate_hz: 100.0")

    def test_a_repeat_of_the_name_of_a_source(self):
        self.refuse("repeat_of", run=", repeat_of: x.mat")
        self.refuse("repeat_of", run=", repeat_of: none")
        other = "}\n- {file: x.mat, name: y, repeat_of: x.mat"
        _, run = ImportCampaign(self.write_map(run=other)).runs
        self.assertEqual((run.file, run.repeat_of), ("y.csv", "x.csv"))
        self.refuse("another run's name", run="}\n- {file: x.mat")


@unittest.skipIf(Writer is None, "mcap is not installed")
class TestMcap(ImportTest):
    def write(self, *messages, metadata=None, packed="ZSTD"):
        path = self.folder / "x.mcap"
        with path.open("wb") as file:
            writer = Writer(file, compression=CompressionType[packed])
            writer.start("", "test")
            if metadata is not None:
                writer.add_metadata("brace_campaign", metadata)
            schema = writer.register_schema("s", "jsonschema", b"{}")
            channel = writer.register_channel("/x", "json", schema)
            for i, data in enumerate(messages):
                writer.add_message(channel, 10**7 * i, data, 0)
            writer.finish()
        return path

    def test_messages(self):
        good = b'{"t": 0.1, "y": 1, "f": NaN}'
        for bad, word in (
            (b'{"t": ' + b"9" * 400 + b"}", "400 digits"),
            (b"[" * 50_000, "levels"),
            (b'{"t": 1e999}', "beyond"),
            (b'{"t": Infinity}', "Infinity"),
            (b'{"t": 1, "t": 2}', "twice"),
            (b"\xff", "UTF-8"),
            (b"", "not JSON"),
        ):
            self.write(good, bad)
            self.refuse(word, file="x.mcap")

    def test_what_unpacks_to_much(self):
        for packed in ("ZSTD", "LZ4", "NONE"):
            if packed != "NONE":
                self.write(b" " * 200_000_000 + b"1", packed=packed)
                self.refuse("memory", file="x.mcap")
            path = self.write(*[b'{"t": 1}'] * 50, packed=packed)
            data = path.read_bytes()
            for at in range(0, len(data), 37):
                path.write_bytes(data[:at])
                self.refuse("x.mcap", file="x.mcap")

    def test_names_without_end(self):
        rows = (
            json.dumps({f"{i}.{k}": 1 for k in range(100)}) for i in range(900)
        )
        self.write(*(row.encode() for row in rows))
        self.refuse("memory", file="x.mcap")

    def test_manifests(self):
        from brace_drake.recording.importing import LoadMcapCampaign

        for text, word in (
            (LAUGHS, "aliases"),
            ("rate_hz: " + "9" * 400, "format"),
            ("a: " + "[" * 9999, "levels"),
            ("", "mapping"),
        ):
            path = self.write(b"{}", metadata={"campaign.yaml": text})
            self.assert_refused(LoadMcapCampaign, path, word)


if __name__ == "__main__":
    unittest.main()
