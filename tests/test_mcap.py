"""Campaigns as MCAP files: out, in, and what a lab's own file holds."""

import json
import random
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.recording import LoadCampaign
from brace_drake.recording.importing.mapped import ImportCampaign
from brace_drake.recording.importing.mcap_file import (
    LoadMcapCampaign,
    WriteMcap,
)
from brace_drake.recording.importing.tables import LoadTable
from tests.commands import run_command

try:
    from mcap.reader import make_reader
    from mcap.writer import Writer
except ImportError:
    Writer = None

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / "tests" / "data" / "example"

MAP = """
format: brace-import/1
device: pad bench
subject: foam
columns:
  time_s: log_time_s
  displacement_m: {from: "pose.y", scale: 0.001}
  force_N: "load[1]"
options: {group: /press}
runs:
- {file: a.mcap, split: fit}
"""


@unittest.skipIf(Writer is None, "mcap is not installed")
class TestMcap(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.file = self.folder / "a.mcap"

    def test_a_campaign_comes_back_as_it_was(self):
        status, said, _ = run_command("export", EXAMPLE, "--out", self.file)
        self.assertEqual(status, 0)
        self.assertIn("5 runs", said)
        out = self.folder / "back"
        self.assertEqual(run_command("import", self.file, "--out", out)[0], 0)
        names = sorted(p.name for p in EXAMPLE.glob("*.csv"))
        self.assertEqual(sorted(p.name for p in out.glob("*.csv")), names)
        before, after = LoadCampaign(EXAMPLE), LoadCampaign(out)
        for key in ("device", "rate_hz", "subject", "stages", "nominal"):
            self.assertEqual(getattr(before, key), getattr(after, key))
        for one, other in zip(before.runs, after.runs, strict=True):
            for key in ("file", "contact", "motion", "repeat_of", "split"):
                self.assertEqual(getattr(one, key), getattr(other, key))
            self.assertEqual(list(one.channels), list(other.channels))
            for name, values in one.channels.items():
                np.testing.assert_array_equal(other.channels[name], values)

    def test_any_reader_finds_topics_times_and_numbers(self):
        campaign = LoadCampaign(EXAMPLE)
        WriteMcap(campaign, self.file)
        with open(self.file, "rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            found = {}
            for _, channel, message in reader.iter_messages():
                rows = found.setdefault(channel.topic, [])
                rows.append((message.log_time, json.loads(message.data)))
        topics = [f"/{r.name}" for r in campaign.runs]
        self.assertEqual(list(found), topics)
        ends = -1
        for recorded in campaign.runs:
            rows = found[f"/{recorded.name}"]
            times = np.array([t for t, _ in rows])
            self.assertGreater(times[0], ends)
            ends = times[-1]
            np.testing.assert_allclose(
                1e-9 * (times - times[0]), recorded.time_s, atol=1e-9
            )
            np.testing.assert_array_equal(
                [sample["ring2_force_y_N"] for _, sample in rows],
                recorded.channels["ring2_force_y_N"],
            )

    def write_foreign(self):
        """A lab's file: a topic of JSON within JSON, and one of bytes."""
        self.time = 0.01 * np.arange(300)
        self.y = 5.0 * (1.0 - np.cos(self.time))
        with open(self.file, "wb") as stream:
            writer = Writer(stream)
            writer.start()
            press = writer.register_channel("/press", "json", 0)
            other = writer.register_channel("/camera", "cdr", 0)
            for i, (t, y) in enumerate(zip(self.time, self.y, strict=True)):
                sample = {"pose": {"y": y}, "load": [0, 3 * y], "who": "lab"}
                when = 10**18 + round(1e9 * t)
                writer.add_message(
                    press, when, json.dumps(sample).encode(), when
                )
                if i % 50 == 0:
                    writer.add_message(other, when, b"\0\1", when)
            writer.finish()

    def test_a_labs_own_topic_comes_in_by_a_map(self):
        self.write_foreign()
        path = self.folder / "map.yaml"
        path.write_text(MAP)
        (recorded,) = ImportCampaign(path).runs
        np.testing.assert_allclose(recorded.time_s, self.time, atol=1e-6)
        channels = recorded.channels
        np.testing.assert_allclose(channels["displacement_m"], 1e-3 * self.y)
        np.testing.assert_allclose(channels["force_N"], 3.0 * self.y)
        table = LoadTable(self.file, {})
        self.assertEqual(set(table), {
            "pose.y", "load[0]", "load[1]", "log_time_s"
        })  # fmt: skip

    def test_what_is_no_campaign_or_topic_has_its_line(self):
        self.write_foreign()
        for words, call in (
            ("holds no campaign", lambda: LoadMcapCampaign(self.file)),
            ("may be /press", lambda: LoadTable(self.file, {"group": "/x"})),
        ):
            with self.assertRaisesRegex(CampaignError, words):
                call()
        status, _, errors = run_command("export", EXAMPLE, "--out", "a.bag")
        self.assertEqual((status, errors.count("\n")), (2, 1))

    def test_damaged_bytes_have_one_line_or_are_read(self):
        self.write_foreign()
        whole, draw = self.file.read_bytes(), random.Random(4)
        refused = 0
        for i in range(150):
            data = bytearray(whole)
            if i % 2:
                del data[draw.randrange(len(data)) :]
            else:
                for _ in range(draw.randrange(1, 6)):
                    data[draw.randrange(len(data))] ^= draw.randrange(1, 256)
            self.file.write_bytes(data)
            try:
                LoadTable(self.file, {"group": "/press"})
            except CampaignError as error:
                self.assertNotIn("\n", str(error))
                refused += 1
        self.assertGreater(refused, 75)


class TestWithout(unittest.TestCase):
    def test_without_the_package_it_is_said_how_to_get_it(self):
        code = (
            "import sys\n"
            "sys.modules['mcap'] = None\n"
            "from brace_drake.cli.main import main\n"
            f"sys.exit(main(['export', {str(EXAMPLE)!r}, '--out', 'a.mcap']))"
        )
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=ROOT,
            capture_output=True,
            text=True,
        )
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("pip install -e '.[mcap]'", done.stderr)
        self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main()
