"""What is written down holds: commands parse, drawings are current."""

import argparse
import contextlib
import io
import json
import re
import shlex
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from itertools import chain
from pathlib import Path

import shtab
import yaml

from brace_drake.cli.data.doctor import _packages, examine_machine
from brace_drake.cli.main import make_parser
from tests.commands import run_command
from tests.shared_data import EXAMPLE
from tests.test_layering import LAYERS

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
# Made from the code, or by a build.
MADE = {"reference", "_build"}


def commands_in(text):
    """Lines that begin with brace-drake, continued ones put together.

    Optional parts of a synopsis, [in brackets], are left out.
    """
    text = re.sub(r"\\\n\s*", " ", text)
    for line in re.findall(r"^\s*(brace-drake .*)$", text, re.MULTILINE):
        if line.startswith("brace-drake COMMAND"):
            continue
        line = re.sub(r"\[[^\[\]]*\]", "", line)
        words = shlex.split(line, comments=True)[1:]
        yield words[: words.index(">")] if ">" in words else words


def parsers(parser, name=""):
    """The parser and those of its commands, with their names."""
    yield name, parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for part, found in action.choices.items():
                yield from parsers(found, f"{name} {part}".strip())


class TestCommands(unittest.TestCase):
    def assert_parses(self, words):
        errors = io.StringIO()
        try:
            with contextlib.redirect_stderr(errors):
                args = make_parser().parse_args(words)
        except SystemExit as stop:
            self.fail(f"{shlex.join(words)}: {stop.code}: {errors.getvalue()}")
        self.assertTrue(callable(args.run))

    def test_every_example_of_the_help_parses(self):
        counted = 0
        for name, parser in parsers(make_parser()):
            found = list(commands_in(parser.epilog or ""))
            with self.subTest(command=name):
                # Parts of a command have their examples in its help.
                if " " not in name:
                    self.assertTrue(found, "no example")
                for words in found:
                    self.assert_parses(words)
            counted += len(found)
        self.assertGreater(counted, 20)

    def test_every_command_of_the_pages_parses(self):
        for page in PAGES:
            if MADE & set(page.relative_to(ROOT).parts):
                continue
            for words in commands_in(page.read_text()):
                with self.subTest(page=page.name, command=shlex.join(words)):
                    self.assert_parses(words)

    def test_every_command_is_in_the_readme(self):
        text = (ROOT / "README.md").read_text()
        for name, _ in parsers(make_parser()):
            with self.subTest(command=name):
                self.assertIn(f"brace-drake {name.split(' ')[0]}", text)

    def test_every_program_that_the_pages_name_is_there(self):
        pattern = r"(?:python|\.venv/bin/python) ((?:tools|diagrams)/\w+\.py)"
        modules = r"tests\.test_\w+"
        for page in PAGES:
            text = page.read_text()
            for name in re.findall(pattern, text):
                with self.subTest(page=page.name, program=name):
                    self.assertTrue((ROOT / name).exists())
            for name in re.findall(modules, text):
                with self.subTest(page=page.name, module=name):
                    path = ROOT / f"{name.replace('.', '/')}.py"
                    self.assertTrue(path.exists())


class TestFamily(unittest.TestCase):
    def test_the_doctor_finds_this_machine_fit(self):
        status, text, _ = run_command("doctor", "--json")
        found = json.loads(text)
        self.assertEqual(status, 0, text)
        for what in ("python", "drake", "cores", "memory", "compiled laws"):
            self.assertEqual(found[what]["status"], "ok", text)
        self.assertEqual(set(found), {f.what for f in examine_machine()})

    def test_a_package_that_is_absent_or_too_old_is_named(self):
        lines = ["numpy>=2", "scipy>=99", 'onnx<1; extra == "x"']
        lines += ['none>=3; extra == "x"', 'numpy; extra == "x"']
        found = {f.what: f for f in _packages(lines)}
        self.assertEqual(found["numpy"].status, "ok")
        self.assertEqual(found["scipy"].status, "missing")
        self.assertRegex(
            found["scipy"].text,
            r"^\d+\.\d+.* is another; pip install 'scipy>=99'$",
        )
        self.assertEqual(found["onnx"].status, "optional")
        self.assertEqual(
            found["none"],
            ("none", "optional", "pip install 'none>=3', for an extra"),
        )

    def test_the_check_is_read_by_a_machine(self):
        status, text, _ = run_command("check", EXAMPLE, "--json")
        self.assertEqual(status, 0)
        self.assertIs(json.loads(text)["usable"], True)
        status, text, _ = run_command("check", EXAMPLE.parent, "--json")
        self.assertEqual(status, 2)
        found = json.loads(text)
        self.assertFalse(found["usable"])
        self.assertEqual(found["problems"][0]["severity"], "error")

    def test_shells_get_a_script_with_every_command(self):
        shells = shtab.SUPPORTED_SHELLS
        self.assertLessEqual({"bash", "zsh", "fish", "tcsh"}, set(shells))
        for shell in shells:
            status, text, _ = run_command("completion", shell)
            self.assertEqual(status, 0)
            for name, _ in parsers(make_parser()):
                self.assertIn(name.split(" ")[0], text)

    def test_ctrl_c_ends_with_130_and_without_a_traceback(self):
        # The campaign is loaded, and work has begun, when the signal comes.
        script = (
            "import os, signal, sys\n"
            # Shells let what they start behind ignore it.
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "from brace_drake.cli import main, options\n"
            "import brace_drake.design.plan as plan\n"
            "def stop(*_): os.kill(os.getpid(), signal.SIGINT)\n"
            "plan.planned_floors = stop\n"
            "sys.exit(main.main(['plan', '--motions', 'push']))\n"
        )
        ended = subprocess.run(
            [sys.executable, "-c", script],
            capture_output=True,
            text=True,
            cwd=ROOT,
            timeout=300,
        )
        self.assertEqual(ended.returncode, 130, ended.stderr)
        self.assertIn("brace-drake: stopped", ended.stderr)
        self.assertNotIn("Traceback", ended.stderr)


@unittest.skipUnless(find_spec("sphinx"), "sphinx is not installed")
class TestBuild(unittest.TestCase):
    def test_the_documentation_builds_without_a_warning(self):
        words = ("-q", "-W", "--keep-going", "-b", "html", "docs")
        with tempfile.TemporaryDirectory() as out:
            ended = subprocess.run(
                [sys.executable, "-m", "sphinx", *words, out],
                capture_output=True,
                text=True,
                cwd=ROOT,
                timeout=900,
            )
            self.assertEqual(ended.returncode, 0, ended.stderr)
            first = (Path(out) / "index.html").read_text()
            self.assertIn("says <strong>why</strong>", first)
            effects = (Path(out) / "reference" / "effects.html").read_text()
            self.assertIn("register_effect", effects)


class TestReference(unittest.TestCase):
    def test_a_page_of_a_part_that_is_gone_is_removed(self):
        path = ROOT / "docs" / "reference.py"
        spec = spec_from_file_location("docs_reference", path)
        reference = module_from_spec(spec)
        spec.loader.exec_module(reference)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "gone.md").write_text("# brace_drake.gone\n")
            reference.WriteReference(folder, make_parser())
            pages = {p.stem for p in folder.iterdir()}
            rooms = {n.split(".")[0] for row in LAYERS for n in row} - {"cli"}
            self.assertEqual(pages, rooms | {"api", "commands"})
            selection = (folder / "selection.md").read_text()
            self.assertIn("brace_drake.selection.search.search", selection)


class TestPages(unittest.TestCase):
    def test_the_drawing_of_the_layers_is_that_of_the_table(self):
        path = ROOT / "docs" / "images" / "layers.svg"
        heights: dict[float, set[str]] = {}
        for element in ElementTree.parse(path).iter():
            if element.tag.endswith("}text"):
                row = heights.setdefault(float(element.get("y")), set())
                row.add(element.text)
        drawn = [heights[y] for y in sorted(heights)]
        self.assertEqual(drawn, [set(row) for row in LAYERS])

    def test_the_architecture_names_the_rooms_in_their_order(self):
        page = (ROOT / "docs" / "architecture.md").read_text()
        table = page.split("## The rooms")[1].split("## ")[0]
        rows = re.findall(r"^\| (`.*?) \|", table, re.M)
        named = [re.findall(r"`([\w.]+?)(?:\.py)?`", row) for row in rows]
        level = {room: i for i, row in enumerate(LAYERS) for room in row}
        self.assertEqual(sorted(chain.from_iterable(named)), sorted(level))
        levels = [min(level[room] for room in row) for row in named]
        self.assertEqual(levels, sorted(levels))

    def test_every_number_of_a_diagnosis_is_computed_where_it_is_said(self):
        page = (ROOT / "docs" / "architecture.md").read_text()
        table = page.split("## What a number")[1].split("## ")[0]
        stored = EXAMPLE.parent / "example_diagnosis" / "diagnosis.json"
        document = json.loads(stored.read_text())
        told = set()
        for keys, places in re.findall(
            r"^\| (`.*?) \| .* \| (`.*?) \|$", table, re.M
        ):
            for key in re.findall(r"`(.+?)`", keys):
                found = document
                for step in key.split("."):
                    with self.subTest(key=key):
                        self.assertIn(step.removesuffix("[]"), found)
                    found = found[step.removesuffix("[]")]
                    found = found[0] if step.endswith("[]") else found
                told.add(key.split(".")[0].removesuffix("[]"))
            for place in re.findall(r"`(.+?\.py)`", places):
                with self.subTest(place=place):
                    paths = (ROOT / "brace_drake").rglob(Path(place).name)
                    self.assertTrue(any(p.match(place) for p in paths))
        heads = {"format", "campaign", "device", "subject_name", "warnings"}
        self.assertEqual(told | heads, set(document))

    def test_links_between_pages_lead_somewhere(self):
        link = re.compile(r"\]\((?!https?:)([^)#\s]+)")
        for page in PAGES:
            if MADE & set(page.relative_to(ROOT).parts):
                continue
            for target in link.findall(page.read_text()):
                if "reference/" in target:
                    continue  # Made by the build, which checks them.
                with self.subTest(page=page.name, target=target):
                    self.assertTrue((page.parent / target).exists())

    def test_the_citation_names_this_version(self):
        cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
        for key in ("cff-version", "title", "authors", "license"):
            self.assertIn(key, cited)
        version = re.search(
            r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.M
        )
        self.assertEqual(cited["version"], version.group(1))


if __name__ == "__main__":
    unittest.main()
