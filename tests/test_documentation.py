"""What is written down holds: commands parse, drawings are current."""

import argparse
import ast
import contextlib
import io
import json
import re
import shlex
import subprocess
import sys
import tempfile
import textwrap
import unittest
import xml.etree.ElementTree as ElementTree
from importlib import import_module
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from itertools import chain
from pathlib import Path

import shtab
import yaml

from brace_drake.cli.data.doctor import _packages, examine_machine
from brace_drake.cli.main import make_parser
from brace_drake.recording.manifest import parse_manifest
from brace_drake.scenario.load import LoadScenario
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


def commands_within(text):
    """Commands with arguments that stand in `quotes` within a sentence."""
    for span in re.findall(r"`(brace-drake [^`]+)`", text):
        words = shlex.split(span.replace("COMMAND --help", "check --help"))[1:]
        if len(words) > 1 and "--help" not in words:
            yield words


def written_pages():
    """Pages that are written by hand."""
    for page in PAGES:
        if not MADE & set(page.relative_to(ROOT).parts):
            yield page


def blocks_in(text, language):
    """The fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.M | re.S)


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
        counted = 0
        for page in written_pages():
            text = page.read_text()
            for words in (*commands_in(text), *commands_within(text)):
                with self.subTest(page=page.name, command=shlex.join(words)):
                    self.assert_parses(words)
                counted += 1
        self.assertGreater(counted, 80)

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


class TestBlocks(unittest.TestCase):
    def test_python_of_the_pages_imports_what_there_is(self):
        for page in written_pages():
            for block in blocks_in(page.read_text(), "python"):
                for node in ast.walk(ast.parse(textwrap.dedent(block))):
                    if not isinstance(node, ast.ImportFrom):
                        continue
                    if not node.module.startswith("brace_drake"):
                        continue
                    module = import_module(node.module)
                    for name in node.names:
                        with self.subTest(page=page.name, name=name.name):
                            self.assertTrue(hasattr(module, name.name))

    def test_scenarios_and_campaigns_of_the_pages_are_accepted(self):
        scenarios = campaigns = 0
        for page in written_pages():
            for block in blocks_in(page.read_text(), "yaml"):
                content = yaml.safe_load(block)
                with self.subTest(page=page.name, keys=list(content)):
                    if "runs" in content and "campaign" in content["format"]:
                        _, problems = parse_manifest(block.encode())
                        errors = [p for p in problems if p.severity == "error"]
                        self.assertEqual(errors, [])
                        campaigns += 1
                    elif "format" not in content:
                        with tempfile.TemporaryDirectory() as folder:
                            path = Path(folder) / "a.scenario.yaml"
                            path.write_text(block)
                            LoadScenario(path)
                        scenarios += 1
        self.assertGreaterEqual((scenarios, campaigns), (2, 2))

    def test_the_tutorial_tells_what_the_stored_diagnosis_has_found(self):
        page = ROOT / "docs" / "tutorials" / "example.md"
        stored = EXAMPLE.parent / "example_diagnosis" / "diagnosis.json"
        found = json.loads(stored.read_text())
        rows = {
            row["name"]: (row, row.get("nominal", 1.0))
            for row in (
                *found["verdict"]["supported"][0]["parameters"],
                *found["subject"]["parameters"],
            )
        }
        told = {
            "arm stiffness, N/m": ("arm_stiffness_N_m", "{:.0f}"),
            "relaxation time, s": ("relaxation_time_s", "{:.3f}"),
            "contact stiffness over nominal": (
                "contact_stiffness_N_m",
                "{:.4f}",
            ),
            "torso mass over nominal": ("torso_mass_kg", "{:.4f}"),
        }
        text = page.read_text()
        for label, (name, form) in told.items():
            row, nominal = rows[name]
            value, low, high = (
                form.format(row[key] / nominal)
                for key in ("value", "lower95", "upper95")
            )
            line = f"{value} ({low} to {high}) |"
            with self.subTest(label=label):
                self.assertRegex(
                    text, rf"\| {label} \| .* \| {re.escape(line)}"
                )
        closed = 100.0 * found["shrink"]["closed"]
        self.assertIn(f"closes {closed:.1f} % of the gap", text)
        probability = 100.0 * found["verdict"]["probability"]
        self.assertIn(f"probability of {probability:.0f} %", text)


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
        words = ["-q", "-W", "--keep-going", "-b", "html", "docs"]
        # How defaults are written: a fifth of the time.
        words += ["-D", "autodoc_preserve_defaults=0"]
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
            captions = re.findall(r'caption-text">(.*?)<', first)
            kinds = ("Tutorials", "How-to guides", "Reference", "Explanation")
            self.assertEqual(tuple(dict.fromkeys(captions)), kinds)
            effects = (Path(out) / "reference" / "effects.html").read_text()
            self.assertIn("register_effect", effects)


def load_reference():
    """The module that makes the pages of the reference."""
    path = ROOT / "docs" / "reference.py"
    spec = spec_from_file_location("docs_reference", path)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class TestReference(unittest.TestCase):
    def test_a_page_of_a_part_that_is_gone_is_removed(self):
        reference = load_reference()
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "gone.md").write_text("# brace_drake.gone\n")
            reference.WriteReference(folder, make_parser())
            pages = {p.stem for p in folder.iterdir()}
            rooms = {n.split(".")[0] for row in LAYERS for n in row} - {"cli"}
            self.assertEqual(pages, rooms | {"api", "commands"})
            selection = (folder / "selection.md").read_text()
            self.assertIn("brace_drake.selection.search.search", selection)

    def test_the_reference_opens_with_the_entry_points(self):
        reference = load_reference()
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            reference.WriteReference(folder, make_parser())
            page = (folder / "api.md").read_text()
            first, parts = page.split("## Parts of the package")
            for names in reference.ENTRY_POINTS.values():
                for entry in names:
                    with self.subTest(entry=entry):
                        self.assertRegex(first, rf"`{entry}`: \w+ \w+")
            self.assertIn("(effects.md): The library of effects", parts)
            effects = (folder / "effects.md").read_text()
            modules = re.findall(r"automodule:: ([\w.]+)", effects)
            card, registry = modules[1:3]
            self.assertEqual(card, "brace_drake.effects.card")
            self.assertEqual(registry, "brace_drake.effects.registry")


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

    def test_the_readme_is_short(self):
        text = (ROOT / "README.md").read_text()
        self.assertLess(len(text.splitlines()), 200)
        # What nobody may miss is said before the first heading.
        first = text.split("\n## ")[0]
        for words in ("Not a medical device", "simulated", "columns"):
            self.assertIn(words, first)

    def test_the_glossary_has_each_term_once(self):
        page = (ROOT / "docs" / "glossary.md").read_text()
        heads = re.findall(r"^- \*\*(.+?)\*\*: ", page, re.M)
        terms = [term for head in heads for term in head.split(", ")]
        self.assertEqual(len(terms), len(set(terms)))
        for term in ("run", "campaign", "block", "effect", "gap", "tolerance"):
            self.assertIn(term, terms)

    def test_every_page_is_in_a_table_of_contents(self):
        index = (ROOT / "docs" / "index.md").read_text()
        listed = set(re.findall(r"^[\w/]+$", index, re.M))
        for page in written_pages():
            if page.name in ("README.md", "index.md"):
                continue
            name = page.relative_to(ROOT / "docs").with_suffix("")
            self.assertIn(str(name), listed)

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

    def test_pages_on_clusters_say_that_a_client_runs_what_is_sent(self):
        for page, words in (
            ("docs/guides/cluster.md", "runs what they send back"),
            ("docs/limits.md", "unpickles, and so runs, what its scheduler"),
        ):
            text = " ".join((ROOT / page).read_text().split())
            self.assertIn(words, text, page)

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
