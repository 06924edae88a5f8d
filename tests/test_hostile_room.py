"""Small files that ask for much room, and sound ones that must not be lost."""

import io
import json
import struct
import tempfile
import tracemalloc
import unittest
import warnings
import zlib
from pathlib import Path
from unittest import mock

import numpy as np
from scipy.io import savemat

from brace_drake.core.errors import CampaignError
from brace_drake.recording.importing.formats import flatten
from brace_drake.recording.importing.tables import LoadTable
from tests.reader_fuzz import time_limit

try:
    from mcap.writer import CompressionType, Writer
except ImportError:
    Writer = None
try:
    import h5py
except ImportError:
    h5py = None
try:
    from nptdms import ChannelObject, TdmsWriter
    from nptdms.log import log_manager
except ImportError:
    TdmsWriter = None

MANY = 400_000
MATLAB = b"MATLAB 5.0".ljust(124) + b"\0\1IM"


def element(kind, data):
    """Of a MATLAB file: type, length, bytes."""
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def matrix(name, kind, *others, sizes=(1, 1)):
    """Of a MATLAB file: a variable of a class, and what is behind its name."""
    head = (
        element(6, struct.pack("<II", kind, 0)),
        element(5, struct.pack(f"<{len(sizes)}i", *sizes)),
        element(1, name),
    )
    return element(14, b"".join((*head, *others)))


def packed(data):
    """A variable as -v7 keeps it."""
    return element(15, zlib.compress(data, 1))


class RoomCase(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def read(self, name, data=None):
        path = self.folder / name
        if data is not None:
            path.write_bytes(data)
        with time_limit(5.0):
            return LoadTable(path, {})

    def assert_refused(self, name, data, words, most_mb=100.0):
        """In one line, and without more memory than so much."""
        tracemalloc.start()
        try:
            with self.assertRaisesRegex(CampaignError, words) as caught:
                self.read(name, data)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        self.assertNotIn("\n", str(caught.exception))
        self.assertLess(peak, 1e6 * most_mb)


class TestJson(RoomCase):
    def test_a_sample_of_a_list_that_never_ends_is_not_taken_apart(self):
        text = json.dumps([{"t": 1, "a": [1] * MANY}])
        self.assert_refused(
            "a.json", text.encode(), f"{MANY + 2} values; allowed: 100000"
        )

    def test_lists_of_nothing_count_as_well(self):
        text = json.dumps([{"t": 1, "a": [[]] * MANY}])
        self.assert_refused("a.json", text.encode(), "allowed: 100000")

    def test_fields_and_items_have_the_names_of_their_places(self):
        sample = {"t": 0.5, "a": {"b": [1, {"c": 2}], "d": 3}, "e": [[4, 5]]}
        found = self.read("a.json", json.dumps([sample] * 3).encode())
        self.assertEqual(
            {name: values[0] for name, values in found.items()},
            {"t": 0.5, "a.b[0]": 1, "a.b[1].c": 2, "a.d": 3, "e[0][0]": 4,
             "e[0][1]": 5},
        )  # fmt: skip
        self.assertEqual(list(found)[:4], ["t", "a.b[0]", "a.b[1].c", "a.d"])

    def test_a_name_that_two_fields_come_to_is_refused(self):
        text = json.dumps([{"a.b": 1, "a": {"b": 2}}])
        self.assert_refused("a.json", text.encode(), "'a.b' is there twice")

    def test_columns_of_numbers_are_those_of_the_file(self):
        text = '{"t": [1, 2, 3.5], "x": [1, null, 3], "y": [1, true, 2]}'
        found = self.read("a.json", text.encode())
        np.testing.assert_array_equal(found["t"], [1.0, 2.0, 3.5])
        np.testing.assert_array_equal(found["x"], [1.0, np.nan, 3.0])
        self.assertEqual(found.words["y"], (2, "TRUE"))

    @unittest.skipIf(Writer is None, "mcap is not installed: the extra mcap")
    def test_a_message_of_a_list_that_never_ends_is_not_taken_apart(self):
        memory = io.BytesIO()
        writer = Writer(memory, compression=CompressionType.ZSTD)
        writer.start("", "x")
        schema = writer.register_schema("x", "jsonschema", b"{}")
        channel = writer.register_channel("/x", "json", schema)
        data = json.dumps({"a": [1] * MANY}).encode()
        writer.add_message(channel, 0, data, 0)
        writer.finish()
        self.assertLess(len(memory.getvalue()), 5000)
        self.assert_refused(
            "a.mcap", memory.getvalue(), f"{MANY + 1} values; allowed: 100000"
        )

    @unittest.skipIf(Writer is None, "mcap is not installed: the extra mcap")
    def test_topics_share_the_memory_that_is_meant_for_a_file(self):
        memory = io.BytesIO()
        writer = Writer(memory)
        writer.start("", "x")
        schema = writer.register_schema("x", "jsonschema", b"{}")
        for topic in range(5):
            channel = writer.register_channel(f"/{topic}", "json", schema)
            for i in range(40):
                writer.add_message(channel, i, b'{"a": 1}', i)
        writer.finish()
        # 40 samples of two columns each: one topic has room, five have not.
        with mock.patch.object(flatten, "LARGEST", 4e-4):
            self.assert_refused("a.mcap", memory.getvalue(), "more numbers")
        with self.assertRaisesRegex(CampaignError, "options.group may be"):
            self.read("a.mcap")


class TestMatlab(RoomCase):
    def test_elements_beyond_those_of_a_matrix_are_not_looked_at(self):
        empty = element(9, b"")
        data = MATLAB + packed(matrix(b"t", 6, empty * MANY))
        self.assert_refused("a.mat", data, "t.* has not the size it says")

    def test_a_struct_of_names_that_never_end_is_refused(self):
        names = element(5, struct.pack("<i", 1)) + element(1, b"a" * MANY)
        data = MATLAB + packed(matrix(b"s", 2, names))
        self.assert_refused("a.mat", data, "more than 10000 fields")

    def test_variables_that_never_end_are_refused(self):
        one = matrix(b"t", 6, element(9, struct.pack("<d", 1.0)))
        self.assert_refused("a.mat", MATLAB + one * 20_000, "10000 variables")

    def test_an_array_of_thousands_of_dimensions_is_refused(self):
        one = element(9, struct.pack("<d", 1.0))
        data = MATLAB + matrix(b"t", 6, one, sizes=[1] * MANY)
        self.assert_refused("a.mat", data, f"{MANY} dimensions")

    def test_complex_numbers_are_told_where_they_are_asked_for(self):
        for version in ("4", "5"):
            memory = io.BytesIO()
            t = np.arange(40.0)
            content = {"t": t, "f": t + 1j}
            savemat(memory, content, format=version)
            found = self.read("a.mat", memory.getvalue())
            with self.subTest(version):
                np.testing.assert_array_equal(found["t"], t)
                self.assertEqual(found.words["f"], (1, "complex"))

    def test_a_struct_s_fields_are_read_by_name(self):
        memory = io.BytesIO()
        t = np.arange(40.0)
        savemat(memory, {"s": {"t": t, "f": 2 * t, "c": t + 1j}})
        path = self.folder / "a.mat"
        path.write_bytes(memory.getvalue())
        found = LoadTable(path, {"group": "s"})
        np.testing.assert_array_equal(found["f"], 2 * t)
        self.assertEqual(list(found.words), ["c"])


class TestArrays(RoomCase):
    def test_bytes_take_no_more_than_the_floats_that_they_become(self):
        memory = io.BytesIO()
        count = 4_000_000
        values = np.arange(count) % 100
        np.savez_compressed(memory, t=values.astype("i1"))
        tracemalloc.start()
        try:
            found = self.read("a.npz", memory.getvalue())
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        np.testing.assert_array_equal(found["t"], values)
        self.assertLess(peak, 11 * count)

    def test_fields_of_a_structured_array_are_columns(self):
        memory = io.BytesIO()
        t = np.arange(40.0)
        kind = [("t", "f8"), ("n", "i2"), ("note", "U3")]
        table = np.zeros(40, kind)
        table["t"], table["n"] = t, 2 * t
        np.save(memory, table)
        found = self.read("a.npy", memory.getvalue())
        self.assertEqual(list(found), ["t", "n"])
        np.testing.assert_array_equal(found["n"], 2 * t)

    def test_fields_that_are_no_numbers_and_no_words_are_refused(self):
        memory = io.BytesIO()
        np.save(memory, np.zeros(40, [("t", "f8"), ("x", "f8", (2,))]))
        self.assert_refused("a.npy", memory.getvalue(), "allowed: numbers or")


@unittest.skipIf(h5py is None, "h5py is not installed: the extra lab")
class TestHdf5(RoomCase):
    def test_a_dataset_without_a_size_spoils_no_other(self):
        with h5py.File(self.folder / "a.h5", "w") as file:
            file["t"] = np.arange(40.0)
            file["nothing"] = h5py.Empty("f8")
        found = self.read("a.h5")
        self.assertEqual(list(found), ["t"])


@unittest.skipIf(TdmsWriter is None, "npTDMS is not installed: the extra lab")
class TestTdms(RoomCase):
    def write(self, **properties):
        path = self.folder / "a.tdms"
        with TdmsWriter(path) as writer:
            values = np.arange(40.0)
            writer.write_segment(
                [ChannelObject("g", "x", values, properties=properties)]
            )
        return path

    def test_what_its_reader_warns_of_is_told_in_the_one_line_alone(self):
        path = self.write()
        data = path.read_bytes()
        for cut in (data[:-100], data[:40]):
            with (
                self.subTest(len(cut)),
                mock.patch.object(log_manager.console_handler, "emit") as said,
            ):
                self.assert_refused(path.name, cut, "Last segment")
            said.assert_not_called()

    def test_a_step_of_time_that_is_none_is_refused(self):
        for step, start in (
            (1e308, 0.0),
            (float("nan"), 0.0),
            (-0.1, 0.0),
            (0.1, float("inf")),
        ):
            path = self.write(wf_increment=step, wf_start_offset=start)
            with self.subTest(step=step), warnings.catch_warnings():
                warnings.simplefilter("error")
                with self.assertRaisesRegex(
                    CampaignError, "'x': wf_incr.*allo"
                ):
                    self.read(path.name)

    def test_a_step_of_time_makes_the_times(self):
        path = self.write(wf_increment=0.25, wf_start_offset=2.0)
        times = self.read(path.name)["wf_time"]
        np.testing.assert_array_equal(times, 2.0 + 0.25 * np.arange(40))


if __name__ == "__main__":
    unittest.main()
