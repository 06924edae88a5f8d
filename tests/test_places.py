"""Places for results: refused before any work, and nobody's file is lost."""

import os
import shutil
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from brace_drake.core.errors import OutputError, is_plain
from brace_drake.core.output import MakeFolder, ReleaseFolders
from brace_drake.core.places import check_file, check_folder, real_path
from brace_drake.core.resources import policy_path, scenario_path
from brace_drake.recording import LoadCampaign, WriteCampaign
from tests.commands import run_command
from tests.shared_data import EXAMPLE
from tests.test_campaign_read import make_campaign

SCENARIO = scenario_path("bench.scenario.yaml")
PNG = b"\x89PNG\r\n\x1a\n"


class PlaceCase(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.addCleanup(ReleaseFolders)

    def make_odd(self):
        """What is no folder, and cannot become one: a path, and the reason."""
        (self.folder / "file").write_text("kept")
        os.mkfifo(self.folder / "pipe")
        (self.folder / "dangling").symlink_to("nowhere")
        (self.folder / "loop").symlink_to("loop")
        return (
            ("file", "is a file"),
            ("file/x", "file is a file"),
            ("pipe", "is a pipe"),
            ("pipe/x", "pipe is a pipe"),
            ("dangling", "is a link to nothing"),
            ("dangling/x", "dangling is a link to nothing"),
            ("loop", "symbolic links"),
            ("loop/x", "symbolic links"),
            ("/dev/null", "is a device"),
            ("/proc/x", "/proc/x: cannot write there"),
            ("n" * 300, "name too long"),
            ("d/" * 2000, "2[0-9]{3} parts; allowed: 200"),
        )

    def refused(self, *words):
        """The one line of a command that ends with status 2."""
        status, said, errors = run_command(*words)
        self.assertEqual(status, 2, said + errors)
        self.assertEqual(errors.count("\n"), 1, errors)
        self.assertTrue(is_plain(errors.strip()), errors)
        return errors


class TestFolders(PlaceCase):
    def test_what_cannot_be_a_folder_is_told_by_its_reason(self):
        for name, why in self.make_odd():
            for look in (check_folder, MakeFolder, self.write):
                with self.subTest(name[:20], look=look):
                    with self.assertRaisesRegex(OutputError, f"(?i){why}"):
                        look(self.folder / name)
        self.assertEqual((self.folder / "file").read_text(), "kept")
        self.assertEqual(
            sorted(os.listdir(self.folder)),
            ["dangling", "file", "loop", "pipe"],
        )

    def write(self, path):
        WriteCampaign(make_campaign(), path)

    def test_a_look_makes_nothing(self):
        check_folder(self.folder / "new" / "results")
        check_file(self.folder / "page.html")
        self.assertEqual(os.listdir(self.folder), [])

    def test_links_are_followed_and_those_of_a_ring_stay(self):
        (self.folder / "there").mkdir()
        (self.folder / "link").symlink_to("there")
        (self.folder / "loop").symlink_to("loop")
        self.assertEqual(
            real_path(self.folder / "link"), real_path(self.folder / "there")
        )
        self.assertEqual(real_path(self.folder / "loop").name, "loop")

    def test_a_campaign_is_written_where_a_link_leads(self):
        (self.folder / "there").mkdir()
        (self.folder / "link").symlink_to("there")
        self.write(self.folder / "link")
        self.assertTrue((self.folder / "link").is_symlink())
        self.assertEqual(len(LoadCampaign(self.folder / "there").runs), 4)


class TestCommands(PlaceCase):
    def test_no_simulation_begins_for_a_place_that_takes_no_campaign(self):
        with mock.patch("brace_drake.model.simulate.RecordBrace") as record:
            for name, why in self.make_odd():
                with self.subTest(name[:20]):
                    told = self.refused(
                        *("simulate", SCENARIO, "--motion", "push"),
                        *("--out", self.folder / name),
                    )
                    self.assertRegex(told, f"(?i){why}")
        record.assert_not_called()

    def test_no_page_of_a_simulation_takes_another_files_place(self):
        paper = self.folder / "paper.html"
        paper.write_text("not a page")
        with mock.patch("brace_drake.model.simulate.RecordBrace") as record:
            for page, why in (
                (paper, "exists and is no page"),
                (self.folder / "page.txt", "allowed: [*].html"),
                (self.folder / "none" / "page.html", "is no folder"),
                (self.folder, "allowed: [*].html"),
            ):
                told = self.refused(
                    *("simulate", SCENARIO, "--motion", "push"),
                    *("--out", self.folder / "new", "--html", page),
                )
                self.assertRegex(told, why)
        record.assert_not_called()
        self.assertEqual(paper.read_text(), "not a page")

    def test_every_folder_of_results_is_looked_at_alike(self):
        odd = self.make_odd()
        for words in (
            ("diagnose", EXAMPLE),
            ("diagnose", EXAMPLE, EXAMPLE),
            ("fit", EXAMPLE),
            ("plan", "--motions", "push"),
            ("predict", policy_path()),
            ("personalize", "none.yaml"),
            (
                "withheld",
                "make",
                "--cases",
                1,
                "--vault",
                self.folder / "vault.json",
            ),
        ):
            for name, why in odd:
                with self.subTest(words[0], name=name[:20]):
                    told = self.refused(*words, "--out", self.folder / name)
                    self.assertRegex(told, f"(?i){why}")

    def test_a_path_that_is_a_ring_of_links_is_no_campaign(self):
        (self.folder / "loop").symlink_to("loop")
        status, said, _ = run_command("check", self.folder / "loop")
        self.assertEqual(status, 2)
        self.assertIn("no such folder", said)


class TestPictures(PlaceCase):
    def setUp(self):
        super().setUp()
        self.table = self.folder / "own.csv"
        rows = "".join(f"{0.01 * i:.2f},{i % 9}\n" for i in range(50))
        self.table.write_text(f"t,x\n{rows}")
        self.before = self.table.read_bytes()

    def plot(self, path):
        return run_command("import", "--init", self.table, "--plot", path)

    def test_a_recording_is_never_replaced_by_its_picture(self):
        named = self.folder / "own.png"
        shutil.copyfile(self.table, named)
        (self.folder / "link.png").symlink_to("own.csv")
        for path in (self.table, named, self.folder / "link.png"):
            status, said, errors = self.plot(path)
            self.assertEqual((status, said), (2, ""), errors)
            self.assertRegex(errors, "allowed: [*].png|exists and is no pict")
        self.assertEqual(self.table.read_bytes(), self.before)
        self.assertEqual(named.read_bytes(), self.before)

    def test_a_picture_is_replaced_by_a_newer_one(self):
        path = self.folder / "own.PNG"
        path.write_bytes(PNG + b"an older one")
        status, said, errors = self.plot(path)
        self.assertEqual(status, 0, errors)
        self.assertIn("columns:", said)
        self.assertEqual(path.read_bytes()[: len(PNG)], PNG)
        self.assertNotIn(b"an older one", path.read_bytes())


class TestNetworks(PlaceCase):
    def test_a_policy_is_not_replaced_by_its_network(self):
        policy = self.folder / "own.npz"
        shutil.copyfile(policy_path(), policy)
        named = self.folder / "own.onnx"
        shutil.copyfile(policy, named)
        before = policy.read_bytes()
        for path, why in ((policy, "allowed: [*].onnx"), (named, "no network")):
            told = self.refused("predict", policy, "--onnx", path)
            self.assertRegex(told, why)
            self.assertEqual(path.read_bytes(), before)


class TestExports(PlaceCase):
    def test_a_lab_s_own_file_is_not_replaced_by_an_export(self):
        path = self.folder / "robot.mcap"
        path.write_bytes(b"\x89MCAP0\r\n\x01 of a robot")
        told = self.refused("export", EXAMPLE, "--out", path)
        self.assertIn("exists and is no exported campaign", told)
        self.assertIn(b"of a robot", path.read_bytes())

    def test_an_export_is_replaced_by_a_newer_one(self):
        path = self.folder / "own.mcap"
        for _ in range(2):
            status, _, errors = run_command("export", EXAMPLE, "--out", path)
            self.assertEqual(status, 0, errors)


if __name__ == "__main__":
    unittest.main()
