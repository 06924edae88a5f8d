"""Imports point one way: each layer knows only those above it."""

import ast
import unittest
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "brace_drake"

# Upper rows know nothing of lower ones; a row's members may know each other.
LAYERS = (
    ("errors", "resources", "versions"),
    ("output", "laws", "campaign", "parallel"),
    ("hardware", "importing"),
    ("kinematics",),
    ("effects",),
    ("scenario",),
    (
        "systems",
        "hydroelastic_pads",
        "twin",
        "torso",
        "articulated",
        "brace_plant",
    ),
    (
        "station",
        "leg_station",
        "pad_station",
        "station_parts",
        "station_safety",
        "brace_station",
        "simulate",
        "simulate_brace",
        "contact_mapping",
    ),
    ("drawing", "playback"),
    ("emulator", "operation"),
    ("gap", "fit", "learning"),
    ("training",),
    ("report",),
    ("experiments",),
    ("withheld",),
    ("transfer",),
    ("cli",),
)
LEVEL = {name: i for i, row in enumerate(LAYERS) for name in row}
# The report reads cards; traces of a diagnosis are made in its form.
ALLOWED = {("gap", "report")}
# What tests a diagnosis must not be made of it.
STAND_IN_KNOWS = {"errors", "output", "withheld"}
WITHHELD_KNOWS = {*STAND_IN_KNOWS, "campaign", "parallel"}


def imports(path):
    """Top-level parts of the package that a file imports."""
    for node in ast.walk(ast.parse(path.read_text())):
        names = []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
            if node.module == "brace_drake":
                names = [f"brace_drake.{a.name}" for a in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        for name in names:
            parts = name.split(".")
            if parts[0] == "brace_drake" and len(parts) > 1:
                yield parts[1]


class TestLayering(unittest.TestCase):
    def test_no_import_points_downwards(self):
        for path in PACKAGE.rglob("*.py"):
            part = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
            if part == "__init__":
                continue
            for imported in imports(path):
                arrow = (part, imported)
                if imported == part or arrow in ALLOWED:
                    continue
                with self.subTest(file=str(path.name), imports=imported):
                    self.assertLessEqual(LEVEL[imported], LEVEL[part])

    def test_the_stand_in_of_the_bench_knows_no_twin(self):
        for path in (PACKAGE / "withheld" / "stand_in").glob("*.py"):
            for imported in imports(path):
                with self.subTest(file=path.name, imports=imported):
                    self.assertIn(imported, STAND_IN_KNOWS)

    def test_withheld_cases_are_made_without_the_twin(self):
        for path in (PACKAGE / "withheld").glob("*.py"):
            for imported in imports(path):
                with self.subTest(file=path.name, imports=imported):
                    self.assertIn(imported, WITHHELD_KNOWS)

    def test_every_part_has_its_place(self):
        parts = {
            p.relative_to(PACKAGE).parts[0].removesuffix(".py")
            for p in PACKAGE.rglob("*.py")
        }
        self.assertEqual(parts - {"__init__"}, set(LEVEL))

    def test_modules_are_of_readable_length(self):
        for path in PACKAGE.rglob("*.py"):
            with self.subTest(file=str(path.relative_to(PACKAGE))):
                self.assertLessEqual(len(path.read_text().splitlines()), 340)


if __name__ == "__main__":
    unittest.main()
