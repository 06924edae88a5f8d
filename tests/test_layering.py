"""Imports point one way: each room knows only those above it."""

import ast
import unittest
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "brace_drake"

# Upper rows know nothing of lower ones. A row's rooms do not know each other.
LAYERS = (
    ("core",),
    ("laws", "recording"),
    ("kinematics",),
    ("effects",),
    ("scenario",),
    ("link.protocol",),
    ("link.device", "link.host"),
    ("devices",),
    ("model", "torso"),
    ("identification",),
    ("recording_faults",),
    ("selection",),
    ("isolation",),
    ("validation",),
    ("discrepancy",),
    ("design",),
    ("monitoring",),
    ("diagnosis",),
    ("report",),
    ("document",),
    ("trend", "sweep"),
    ("playback", "drawing"),
    ("link.emulator",),
    ("link.operation",),
    ("learning",),
    ("withheld",),
    ("experiments",),
    ("results",),
    ("cli",),
)
LEVEL = {name: i for i, row in enumerate(LAYERS) for name in row}
# Arrows that still point the wrong way.
WRONG: set[tuple[str, str]] = set()
# What tests a diagnosis must not be made of it.
SIMULATOR_KNOWS = {"core", "withheld"}
WITHHELD_KNOWS = {*SIMULATOR_KNOWS, "recording"}
MOST_LINES, MOST_FILES = 300, 15


def room_of(name):
    """The room of a module's dotted name below the package, None outside."""
    parts = name.split(".")
    for end in range(len(parts), 0, -1):
        if ".".join(parts[:end]) in LEVEL:
            return ".".join(parts[:end])
    return None


def imports(path):
    """Dotted names below the package that a file imports."""
    for node in ast.walk(ast.parse(path.read_text())):
        names = []
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        for name in names:
            if name.startswith("brace_drake."):
                yield name.removeprefix("brace_drake.")


def modules():
    """Path and dotted name of each module with something in it."""
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        name = ".".join(p for p in parts if p != "__init__")
        if name:
            yield path, name


class TestLayering(unittest.TestCase):
    def test_no_import_points_downwards(self):
        for path, name in modules():
            room = room_of(name)
            if room is None:
                continue
            for imported in imports(path):
                other = room_of(imported)
                if other in (room, None) or (room, other) in WRONG:
                    continue
                with self.subTest(file=name, imports=imported):
                    self.assertLess(LEVEL[other], LEVEL[room])

    def test_the_simulator_of_withheld_cases_knows_no_twin(self):
        for path in (PACKAGE / "withheld" / "simulator").glob("*.py"):
            for imported in imports(path):
                with self.subTest(file=path.name, imports=imported):
                    self.assertIn(imported.split(".")[0], SIMULATOR_KNOWS)

    def test_withheld_cases_are_made_without_the_twin(self):
        for path in (PACKAGE / "withheld").glob("*.py"):
            for imported in imports(path):
                with self.subTest(file=path.name, imports=imported):
                    self.assertIn(imported.split(".")[0], WITHHELD_KNOWS)

    def test_every_module_has_its_room(self):
        for _, name in modules():
            # A folder of rooms holds no code of its own.
            if any(room.startswith(f"{name}.") for room in LEVEL):
                continue
            with self.subTest(module=name):
                self.assertIsNotNone(room_of(name))

    def test_modules_are_of_readable_length(self):
        for path, name in modules():
            with self.subTest(module=name):
                lines = len(path.read_text().splitlines())
                self.assertLessEqual(lines, MOST_LINES)

    def test_rooms_hold_few_files(self):
        for folder in {path.parent for path, _ in modules()}:
            with self.subTest(room=str(folder.relative_to(PACKAGE))):
                files = list(folder.glob("*.py"))
                self.assertLessEqual(len(files), MOST_FILES)


if __name__ == "__main__":
    unittest.main()
