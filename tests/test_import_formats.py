"""Each format gives back the numbers that another library wrote into it."""

import datetime
import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.recording.importing.tables import LoadTable

try:
    import h5py
    import openpyxl
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore
except ImportError:
    h5py = None

TIME = np.arange(50) / 100.0
TRAVEL = np.sin(TIME)


class TestFormats(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def check(self, name, time="Time", travel="Travel", **options):
        table = LoadTable(self.folder / name, options)
        np.testing.assert_allclose(table[time], TIME, atol=1e-9)
        np.testing.assert_allclose(table[travel], TRAVEL, atol=1e-9)
        return table

    def write(self, name, text, encoding="utf-8"):
        (self.folder / name).write_bytes(text.encode(encoding))

    def test_text_without_names_has_numbered_columns(self):
        rows = [
            f"{t:.9f} \t {y:.9f}" for t, y in zip(TIME, TRAVEL, strict=True)
        ]
        self.write("a.dat", "\n".join(rows))
        self.check("a.dat", "1", "2", delimiter=" ")
        self.write("b.csv", "\n".join(r.replace(" \t ", ",") for r in rows))
        self.check("b.csv", "1", "2")

    def test_text_of_windows_and_of_excel_is_read(self):
        rows = [f"{t:.9f};{y:.9f}" for t, y in zip(TIME, TRAVEL, strict=True)]
        text = "\r\n".join(["Zeit µs;Weg °", *rows])
        for encoding in ("cp1252", "utf-16", "utf-8-sig"):
            with self.subTest(encoding):
                self.write("a.csv", text, encoding)
                self.check("a.csv", "Zeit µs", "Weg °", delimiter=";")

    def test_json_as_samples_as_columns_and_by_lines(self):
        samples = [
            {"Time": t, "at": {"y": [0.0, y]}, "note": "ok"}
            for t, y in zip(TIME.tolist(), TRAVEL.tolist(), strict=True)
        ]
        self.write("a.json", json.dumps(samples))
        self.check("a.json", travel="at.y[1]")
        self.write("a.jsonl", "\n".join(map(json.dumps, samples)))
        self.check("a.jsonl", travel="at.y[1]")
        columns = {"Time": TIME.tolist(), "Travel": TRAVEL.tolist(), "n": "x"}
        self.write("b.json", json.dumps({"run": columns}))
        self.check("b.json", group="run")

    def test_arrays_of_numpy(self):
        np.savez(self.folder / "a.npz", Time=TIME, data=np.c_[TIME, TRAVEL])
        self.check("a.npz", travel="data(2)")
        np.save(self.folder / "a.npy", np.c_[TIME, TRAVEL])
        self.check("a.npy", "1", "2")

    @unittest.skipIf(h5py is None, "h5py is not installed")
    def test_hdf5_and_what_matlab_makes_of_it(self):
        with h5py.File(self.folder / "a.h5", "w") as file:
            file["run/Time"], file["run/Travel"] = TIME, TRAVEL
            file["elsewhere"] = h5py.ExternalLink("/etc/passwd", "/x")
        self.check("a.h5", "run/Time", "run/Travel")
        self.check("a.h5", group="run")
        with h5py.File(self.folder / "b.mat", "w", userblock_size=512) as file:
            # MATLAB's matrix of N rows and 2 columns is one of 2 rows here.
            file["data"] = np.c_[TIME, TRAVEL].T
            file["s/Time"], file["s/Travel"] = TIME[None, :], TRAVEL[None, :]
        head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM"
        with open(self.folder / "b.mat", "r+b") as file:
            file.write(head)
        self.check("b.mat", "data(1)", "data(2)")
        self.check("b.mat", group="s")

    @unittest.skipIf(h5py is None, "openpyxl is not installed")
    def test_a_sheet_of_excel_with_a_preamble_and_times_of_day(self):
        book = openpyxl.Workbook()
        sheet = book.active
        sheet.append(["Measured by", "A"])
        sheet.append(["Time", "Travel", "Clock", "Note"])
        start = datetime.datetime(2026, 11, 26, 10)
        for t, y in zip(TIME.tolist(), TRAVEL.tolist(), strict=True):
            sheet.append([t, y, start + datetime.timedelta(seconds=t), "ok"])
        book.create_sheet("empty")
        book.save(self.folder / "a.xlsx")
        table = self.check("a.xlsx", group="Sheet", skip_lines=1)
        self.assertNotIn("Note", table)
        clock = table["Clock"] - table["Clock"][0]
        np.testing.assert_allclose(clock, TIME, atol=1e-3)
        with self.assertRaisesRegex(
            CampaignError, "there are 'Sheet', 'empty'"
        ):
            LoadTable(self.folder / "a.xlsx", {})

    @unittest.skipIf(h5py is None, "rosbags is not installed")
    def test_bags_of_ros_2_of_both_kinds(self):
        for plugin in (StoragePlugin.SQLITE3, StoragePlugin.MCAP):
            with self.subTest(plugin):
                name = plugin.name.lower()
                self.write_bag(self.folder / name, plugin)
                columns = {"time": "stamp_s", "travel": "position.elbow"}
                self.check(name, **columns, group="/joint_states")
                (file,) = (self.folder / name).glob(f"{name}.*")
                table = self.check(
                    f"{name}/{file.name}", **columns, group="/joint_states"
                )
                np.testing.assert_allclose(table["log_time_s"], 2.0 * TIME)
                table = self.check(name, **columns, group="/joint_states, /cmd")
                command = table["/cmd:data"]
                # The value that was sent last: at 0.055 s, then at 0.505 s.
                self.assertTrue(np.isnan(command[:3]).all())
                np.testing.assert_array_equal(command[3:26], 1.0)
                np.testing.assert_array_equal(command[26:], 2.0)
                with self.assertRaisesRegex(CampaignError, "no topic '/x'"):
                    LoadTable(self.folder / name, {"group": "/x"})

    def write_bag(self, path, plugin):
        store = get_typestore(Stores.ROS2_HUMBLE)
        State = store.types["sensor_msgs/msg/JointState"]
        Header = store.types["std_msgs/msg/Header"]
        Time = store.types["builtin_interfaces/msg/Time"]
        with Writer(path, version=9, storage_plugin=plugin) as bag:
            topic = bag.add_connection(
                "/joint_states", State.__msgtype__, typestore=store
            )
            for t, y in zip(TIME, TRAVEL, strict=True):
                stamp = Time(int(t) + 7, round(1e9 * (t % 1)))
                empty = np.zeros(0)
                names = ["shoulder", "elbow"]
                message = State(
                    Header(stamp, ""), names, np.array([1.0, y]), empty, empty
                )
                data = store.serialize_cdr(message, State.__msgtype__)
                bag.write(topic, round(2e9 * t) + 5, data)
            Number = store.types["std_msgs/msg/Float64"]
            topic = bag.add_connection(
                "/cmd", Number.__msgtype__, typestore=store
            )
            for when, value in ((0.055, 1.0), (0.505, 2.0)):
                data = store.serialize_cdr(Number(value), Number.__msgtype__)
                bag.write(topic, round(1e9 * when), data)

    def test_broken_files_are_refused_in_a_line(self):
        for name in ("h5", "xlsx", "db3", "bag", "npy", "npz", "json", "jsonl"):
            for content in (b"", b"PK\3\4" + bytes(99)):
                path = self.folder / f"a.{name}"
                path.write_bytes(content)
                with self.subTest(name, content=content[:4]):
                    with self.assertRaises(CampaignError) as caught:
                        LoadTable(path, {})
                    self.assertNotIn("\n", str(caught.exception))
                    self.assertIn(f"a.{name}: ", str(caught.exception))


if __name__ == "__main__":
    unittest.main()
