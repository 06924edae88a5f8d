"""A lab's own files as campaigns: what went in comes out, in SI units."""

import tempfile
import unittest
from pathlib import Path

import numpy as np
from scipy.io import savemat

from brace_drake.core.errors import CampaignError
from brace_drake.recording import LoadCampaign, WriteCampaign
from brace_drake.recording.columns import DEVICES
from brace_drake.recording.importing.derived import derivable, derive
from brace_drake.recording.importing.expand import expand_rules
from brace_drake.recording.importing.mapped import ImportCampaign

try:
    from nptdms import ChannelObject, TdmsWriter
except ImportError:
    TdmsWriter = None

MAP = """
format: brace-import/1
device: pad bench
subject: foam
columns:
  time_s: Time
  displacement_m: {from: Travel, scale: 0.001}
  force_N: {from: Load, offset: -0.5}
"""


class TestImport(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.time = np.arange(400) / 100.0
        self.travel = 5.0 * (1.0 - np.cos(self.time))
        self.load = 3.0 * self.travel + 0.5 + 0.01 * np.sin(40 * self.time)

    def map(self, file, more="", text=MAP):
        path = self.folder / "map.yaml"
        path.write_text(
            f"{text}{more}\nruns:\n- {{file: {file}, split: fit}}\n"
        )
        return path

    def check(self, file, more=""):
        campaign = ImportCampaign(self.map(file, more))
        out = self.folder / "out"
        WriteCampaign(campaign, out)
        (run,) = LoadCampaign(out).runs
        np.testing.assert_allclose(run.time_s, self.time, atol=1e-6)
        np.testing.assert_allclose(
            run.channels["displacement_m"], 1e-3 * self.travel, atol=1e-8
        )
        np.testing.assert_allclose(
            run.channels["force_N"], self.load - 0.5, atol=1e-5
        )

    def write_text(self, delimiter=",", decimal="."):
        rows = [f"Time{delimiter}Note{delimiter}Travel{delimiter}Load"]
        for row in zip(self.time, self.travel, self.load, strict=True):
            t, y, f = (f"{v:.9f}".replace(".", decimal) for v in row)
            rows.append(delimiter.join([t, "ok", y, f]))
        (self.folder / "a.csv").write_text("\n".join(rows) + "\n")

    def test_text_with_commas_and_as_germans_write_it(self):
        self.write_text()
        self.check("a.csv")
        self.write_text(";", ",")
        (self.folder / "out").rename(self.folder / "first")
        self.check("a.csv", 'options: {delimiter: ";", decimal: ","}')
        # The file itself shows it as well.
        (self.folder / "out").rename(self.folder / "second")
        self.check("a.csv")

    def test_matlab_vectors_a_struct_and_a_matrix(self):
        columns = {"Time": self.time, "Travel": self.travel, "Load": self.load}
        savemat(self.folder / "a.mat", columns)
        self.check("a.mat")
        savemat(self.folder / "b.mat", {"run1": columns})
        (self.folder / "out").rename(self.folder / "first")
        self.check("b.mat", "options: {group: run1}")
        matrix = np.column_stack(list(columns.values()))
        savemat(self.folder / "c.mat", {"data": matrix})
        path = self.map("c.mat")
        text = path.read_text().replace("Time", "data(1)")
        text = text.replace("Travel", "data(2)").replace("Load", "data(3)")
        path.write_text(text)
        (run,) = ImportCampaign(path).runs
        np.testing.assert_allclose(
            run.channels["force_N"], self.load - 0.5, atol=1e-12
        )

    @unittest.skipIf(TdmsWriter is None, "npTDMS is not installed")
    def test_tdms_with_its_own_time_and_with_a_channel_of_it(self):
        channels = [("Time", self.time), ("Travel", self.travel)]
        channels.append(("Load", self.load))
        waveform = {"wf_increment": 0.01, "wf_start_offset": 0.0}
        with TdmsWriter(self.folder / "a.tdms") as writer:
            writer.write_segment(
                [ChannelObject("g", n, v, waveform) for n, v in channels]
            )
        self.check("a.tdms", "options: {group: g}")
        path = self.map("a.tdms")
        path.write_text(path.read_text().replace(": Time", ": wf_time"))
        (run,) = ImportCampaign(path).runs
        np.testing.assert_allclose(run.time_s, self.time, atol=1e-9)

    def test_uneven_samples_are_made_even(self):
        draw = np.random.default_rng(1)
        self.time = np.sort(draw.uniform(0.0, 4.0, 4000))
        self.time -= self.time[0]
        self.travel = 5.0 * (1.0 - np.cos(self.time))
        self.load = 3.0 * self.travel + 0.5
        self.write_text()
        (run,) = ImportCampaign(self.map("a.csv", "rate_hz: 100")).runs
        np.testing.assert_allclose(np.diff(run.time_s), 0.01, atol=1e-9)
        # Linear interpolation: at most a h^2 / 8.
        np.testing.assert_allclose(
            run.channels["displacement_m"],
            5e-3 * (1.0 - np.cos(run.time_s)),
            atol=5e-3 * 0.02**2 / 8,
        )

    def test_braces_stand_for_a_rule_each(self):
        rules = {
            "leg{1..3}_length_m": {"from": "L{0..2} (mm)", "unit": "mm"},
            "ring2_force_{x,y,z}_N": "F{}",
            "torso_{x,y}_m": {"from": {"a{}": 1.0, "b{}": -1.0}},
            "time_s": "t",
        }
        self.assertEqual(
            expand_rules("", rules),
            {
                **{
                    f"leg{k}_length_m": {"from": f"L{k - 1} (mm)", "unit": "mm"}
                    for k in (1, 2, 3)
                },
                **{f"ring2_force_{a}_N": f"F{a}" for a in "xyz"},
                **{
                    f"torso_{a}_m": {"from": {f"a{a}": 1.0, f"b{a}": -1.0}}
                    for a in "xy"
                },
                "time_s": "t",
            },
        )
        for wrong, words in (
            ({"leg{1..3}_length_m": "L{1..2}"}, "allowed: 3"),
            ({"leg{}_length_m": "L"}, "allowed: a range"),
            ({"leg{1..2}_length_m": "a", "leg2_length_m": "b"}, "there twice"),
        ):
            with self.assertRaisesRegex(CampaignError, words):
                expand_rules("", wrong)

    def test_columns_are_added_up_by_their_factors(self):
        self.write_text()
        text = MAP.replace(
            "{from: Load, offset: -0.5}",
            "{from: {Load: 2, Travel: -3.0}, scale: 0.5, offset: 1}",
        )
        (run,) = ImportCampaign(self.map("a.csv", text=text)).runs
        np.testing.assert_allclose(
            run.channels["force_N"],
            self.load - 1.5 * self.travel + 1.0,
            atol=1e-7,
        )

    def test_desired_rates_that_are_absent_are_derivatives(self):
        y, h = "ring2_y_desired_m", 0.005
        v, a = "ring2_vy_desired_m_s", "ring2_ay_desired_m_s2"
        channels = DEVICES["bench stage 2"].channels
        self.assertEqual(derivable(channels, [y]), {v: y, a: v})
        self.assertEqual(derivable(channels, [y, v]), {a: v})
        time = h * np.arange(400)
        way = {"time_s": time, y: 0.01 * np.sin(3.0 * time)}
        found = derive(way, {v: y, a: v})
        # Central differences are off by h^2 / 6 of the third derivative.
        inner = slice(2, -2)
        for name, exact, order in (
            (v, 0.03 * np.cos(3.0 * time), 3),
            (a, -0.09 * np.sin(3.0 * time), 4),
        ):
            most = 0.01 * 3.0**order * h**2 / 3.0
            error = np.abs(found[name] - exact)[inner].max()
            self.assertLess(error, most)

    def test_every_mistake_has_its_line(self):
        self.write_text()
        (self.folder / "short.csv").write_text("Time,Travel,Load\n1,2\n")
        (self.folder / "one.csv").write_text("Time,Travel,Load\n1,2,3\n")
        (self.folder / "bad.mat").write_text("no")
        for file, more, text, words in (
            ("none.csv", "", MAP, "none.csv: cannot be read: No such file"),
            ("a.pdf", "", MAP, "known are"),
            ("short.csv", "", MAP, "row 1 has 2 fields"),
            ("one.csv", "", MAP, "one.csv: it has 1 row; allowed: 10"),
            ("bad.mat", "", MAP, "not a MATLAB file"),
            ("a.csv", "", MAP.replace("Travel", "Trvel"), "mean Travel"),
            ("a.csv", "", MAP.replace("force_N", "force_n"), "mean force_N"),
            ("a.csv", "", MAP.replace("  time_s: Time\n", ""), "no time_s"),
            ("a.csv", "", MAP.replace("pad bench", "press"), "is 'press'"),
            ("a.csv", "", MAP.replace("0.001", "mm"), "scale is 'mm'"),
            ("a.csv", "rate: 3", MAP, "did you mean rate_hz"),
            ("a.csv", "rate_hz: 500", MAP, "cannot be made 500 Hz"),
        ):
            with self.subTest(words=words):
                with self.assertRaises(CampaignError) as caught:
                    ImportCampaign(self.map(file, more, text))
                self.assertIn(words, str(caught.exception))
                self.assertNotIn("\n", str(caught.exception))


if __name__ == "__main__":
    unittest.main()
