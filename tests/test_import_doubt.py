"""What a file leaves in doubt is refused or renamed, never guessed."""

import io
import json
import tempfile
import unittest
import zipfile
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import BraceError, CampaignError
from brace_drake.recording import WriteCampaign
from brace_drake.recording.importing.draft import draft_map, read_draft
from brace_drake.recording.importing.draft_plot import plot_draft
from brace_drake.recording.importing.mapped import ImportCampaign
from brace_drake.recording.importing.tables import LoadTable

try:
    from nptdms import ChannelObject, TdmsWriter
except ImportError:
    TdmsWriter = None

MAP = {
    "format": "brace-import/1",
    "device": "pad bench",
    "columns": {"time_s": "t", "displacement_m": "x", "force_N": "f"},
    "runs": [{"file": "a.csv", "split": "fit"}],
}
ROWS = [f"{0.01 * i:.2f},{0.001 * i:.3f},{i % 7}" for i in range(200)]


class TestDoubt(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def write(self, text, name="a.csv"):
        path = self.folder / name
        path.write_text(text)
        return path

    def map(self, **changes):
        return self.write(yaml.safe_dump({**MAP, **changes}), "map.yaml")

    def test_a_quote_that_is_left_open_swallows_no_rows(self):
        rows = [*ROWS[:50], '0.50,0.050,"-1.3', *ROWS[51:]]
        self.write("\n".join(["t,x,f", *rows]))
        with self.assertRaises(CampaignError):
            ImportCampaign(self.map())
        rows[60] = '9",0.06,1'
        self.write("\n".join(["t,x,f", *rows]))
        with self.assertRaises(CampaignError):
            ImportCampaign(self.map())

    def test_of_columns_that_share_a_name_none_has_it(self):
        path = self.write("t,x,x,f\n1,2,3,4\n2,3,4,5\n")
        table = LoadTable(path, {})
        self.assertEqual(list(table), ["t", "x(1)", "x(2)", "f"])
        np.testing.assert_array_equal(table["x(2)"], [3.0, 4.0])
        with self.assertRaisesRegex(CampaignError, r"no column 'x'"):
            ImportCampaign(self.map())
        sample = json.dumps([{"a.b": 1, "a": {"b": 2}}] * 3)
        with self.assertRaisesRegex(CampaignError, "there twice"):
            LoadTable(self.write(sample, "a.json"), {})

    def test_a_constant_has_its_unit(self):
        self.write("\n".join(["t,x,f", *ROWS]))
        columns = {
            **MAP["columns"],
            "force_N": {"constant": 5, "unit": "kN", "scale": 2, "offset": 1},
        }
        (run,) = ImportCampaign(self.map(columns=columns)).runs
        np.testing.assert_array_equal(run.channels["force_N"], 10001.0)

    def test_beside_a_decimal_comma_a_point_is_no_decimal(self):
        path = self.write("t;x\n0,1;1.234\n0,2;2,5\n")
        options = {"delimiter": ";", "decimal": ","}
        np.testing.assert_array_equal(
            LoadTable(path, options)["x"], [np.nan, 2.5]
        )

    def test_parts_of_runs_do_not_overwrite_each_other(self):
        rows = [f"{0.02 * i:.2f},{0.001 * i:.3f},1" for i in range(200)]
        del rows[90:100]
        self.write("\n".join(["t,x,f", *rows]))
        self.write("\n".join(["t,x,f", *ROWS]), "b.csv")
        runs = [
            {"file": "a.csv", "name": "a"},
            {"file": "b.csv", "name": "a_1"},
        ]
        with self.assertRaisesRegex(CampaignError, "two runs would be"):
            ImportCampaign(self.map(runs=runs, gaps="split"))

    def test_no_run_replaces_the_manifest_and_no_name_breaks_a_table(self):
        self.write("\n".join(["t,x,f", *ROWS]))
        for name in ("campaign.yaml", "label.yaml"):
            campaign = ImportCampaign(self.map())
            vars(campaign.runs[0])["file"] = name
            with self.assertRaisesRegex(BraceError, "no run can be"):
                WriteCampaign(campaign, self.folder / "out")
        campaign = ImportCampaign(self.map())
        campaign.runs[0].channels['a,b"'] = campaign.runs[0].time_s
        with self.assertRaisesRegex(BraceError, "no column can be"):
            WriteCampaign(campaign, self.folder / "out")

    @unittest.skipIf(TdmsWriter is None, "npTDMS is not installed")
    def test_channels_of_other_clocks_have_to_be_chosen(self):
        path = self.folder / "a.tdms"
        with TdmsWriter(path) as writer:
            for group, step in (("A", 0.001), ("B", 0.002)):
                properties = {"wf_increment": step, "wf_start_offset": 0.0}
                writer.write_segment(
                    [ChannelObject(group, "x", np.arange(5.0), properties)]
                )
        with self.assertRaisesRegex(CampaignError, "clocks of their own"):
            LoadTable(path, {})
        table = LoadTable(path, {"group": "B"})
        np.testing.assert_allclose(table["wf_time"], 0.002 * np.arange(5))

    def test_a_name_cannot_write_into_a_draft(self):
        samples = [{"zz\nscenario: /etc/hostname": i, "\x1b[2J": 1.0, "t": i}
                   for i in range(9)]  # fmt: skip
        text = draft_map(read_draft(self.write(json.dumps(samples), "a.json")))
        self.assertNotIn("\x1b", text)
        self.assertNotIn("scenario", yaml.safe_load(text))

    def test_what_matplotlib_would_read_as_a_formula_is_drawn(self):
        path = self.write("t,f$\\foo$\n1,2\n2,3\n3,4\n")
        picture = plot_draft(read_draft(path))
        self.assertTrue(picture.startswith(b"\x89PNG"))

    def test_arrays_of_billions_of_columns_are_refused_at_once(self):
        head = {"descr": "<f8", "fortran_order": False, "shape": (0, 10**9)}
        memory = io.BytesIO()
        np.lib.format.write_array_header_1_0(memory, head)
        path = self.folder / "a.npz"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("x.npy", memory.getvalue())
        with self.assertRaisesRegex(CampaignError, "columns; allowed"):
            LoadTable(path, {})


if __name__ == "__main__":
    unittest.main()
