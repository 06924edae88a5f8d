"""Every notebook runs from its first cell to its last, and is short."""

import os
import unittest
from pathlib import Path

try:
    import nbformat
    from nbclient import NotebookClient
except ImportError as error:
    raise unittest.SkipTest(
        "nbclient is not installed: pip install -e '.[dev]'"
    ) from error

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = ROOT / "notebooks"
# A cell on a machine that others share; alone, a whole notebook takes less
# than a minute.
_PATIENCE = 600


def load(name):
    return nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)


class TestNotebooks(unittest.TestCase):
    def run_through(self, name):
        """Executes a notebook; a cell that raises fails the test."""
        paths = [str(ROOT), os.environ.get("PYTHONPATH", "")]
        env = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(filter(None, paths)),
            "OPENBLAS_NUM_THREADS": "1",
            "MPLBACKEND": "module://matplotlib_inline.backend_inline",
        }
        client = NotebookClient(
            load(name),
            timeout=_PATIENCE,
            kernel_name="python3",
            resources={"metadata": {"path": str(NOTEBOOKS)}},
        )
        client.execute(env=env)

    def test_1_the_twin_and_its_diagram(self):
        self.run_through("1_the_twin_and_its_diagram")

    def test_2_from_a_campaign_to_contact_parameters(self):
        self.run_through("2_from_a_campaign_to_contact_parameters")

    def test_3_where_the_gap_lies_and_what_causes_it(self):
        self.run_through("3_where_the_gap_lies_and_what_causes_it")

    def test_4_your_own_effect_in_thirty_lines(self):
        self.run_through("4_your_own_effect_in_thirty_lines")

    def test_5_controllers_compared(self):
        self.run_through("5_controllers_compared")

    def test_6_train_and_examine_rlpic(self):
        self.run_through("6_train_and_examine_rlpic")

    def test_7_from_a_scan_to_a_twin(self):
        self.run_through("7_from_a_scan_to_a_twin")

    def test_8_plan_a_campaign_and_a_withheld_check(self):
        self.run_through("8_plan_a_campaign_and_a_withheld_check")

    def test_9_the_serial_link_with_the_emulator(self):
        self.run_through("9_the_serial_link_with_the_emulator")

    def test_10_your_own_robot(self):
        self.run_through("10_your_own_robot")

    def test_each_notebook_has_its_test(self):
        names = {p.stem for p in NOTEBOOKS.glob("*.ipynb")}
        tests = {n.removeprefix("test_") for n in dir(self)}
        self.assertEqual(len(names), 10)
        self.assertLessEqual(names, tests)

    def test_each_is_short_and_without_outputs(self):
        for path in NOTEBOOKS.glob("*.ipynb"):
            cells = [c for c in load(path.stem).cells if c.cell_type == "code"]
            with self.subTest(notebook=path.name):
                self.assertLess(len(cells), 15)
                for cell in cells:
                    self.assertEqual(cell.outputs, [])
                    self.assertIsNone(cell.execution_count)


if __name__ == "__main__":
    unittest.main()
