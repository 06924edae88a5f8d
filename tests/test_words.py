"""Words that are out stay out of pages, help, messages and names."""

import argparse
import ast
import json
import re
import unittest
from pathlib import Path

from brace_drake.cli.main import make_parser
from tests.test_documentation import MADE, PAGES, parsers

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "brace_drake"
TABLE = ROOT / "tests" / "data" / "words_out.txt"
OTHER_PAGES = (ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md")
# Names of fields that files and packages of others use.
KEPT_NAMES = {"impostors", "cube"}


def words_out():
    """Pairs of a compiled pattern and what to say instead."""
    for line in TABLE.read_text().splitlines():
        if line and not line.startswith("#"):
            pattern, _, instead = line.partition(" -> ")
            yield re.compile(rf"\b(?:{pattern})\b", re.IGNORECASE), instead


WORDS_OUT = tuple(words_out())
_ANY = re.compile("|".join(p.pattern for p, _ in WORDS_OUT), re.IGNORECASE)


def found_in(text):
    """Words that are out in a text, each with what to say instead.

    Code in `quotes` is no prose.
    """
    text = " ".join(re.sub(r"`[^`]*`", "``", text).split())
    if not _ANY.search(text):
        return []
    return [
        f"{text[max(0, m.start() - 40) : m.end() + 40]!r}: say {instead!r}"
        for pattern, instead in WORDS_OUT
        for m in pattern.finditer(text)
    ]


def prose_of(path):
    """Docstrings and messages of a module, with their lines."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if re.search(r"\S\s\S", node.value):
                yield node.lineno, node.value


def names_of(path):
    """Public names that a module defines: its own, of functions, classes,
    arguments and fields.
    """
    yield path.stem
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.AnnAssign) and isinstance(
            node.target, ast.Name
        ):
            yield node.target.id


def words_of(name):
    """A name in snake_case or CamelCase as words."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_", " ", name)


def template_text(text):
    """What a template shows: without its tags and expressions."""
    text = re.sub(r"\{#.*?#\}|\{%.*?%\}|\{\{.*?\}\}", " ", text, flags=re.S)
    return re.sub(r"<[^>]*>", " ", text)


class TestWords(unittest.TestCase):
    def assert_plain(self, text, **place):
        with self.subTest(**place):
            self.assertEqual(found_in(text), [])

    def test_the_table_names_what_to_say_instead(self):
        self.assertGreater(len(WORDS_OUT), 20)
        for pattern, instead in WORDS_OUT:
            self.assertTrue(instead.strip(), pattern.pattern)
            self.assertFalse(pattern.search(instead), pattern.pattern)

    def test_a_word_that_is_out_is_found(self):
        self.assertEqual(len(found_in("It is\nled  back by a Decoy.")), 2)
        self.assertEqual(found_in("the field `decoys`, a racetrack"), [])
        shown = template_text("<b class='decoy'>{{ decoy }} gap</b>")
        self.assertEqual(shown.split(), ["gap"])
        self.assertEqual(words_of("MakeDecoyRun"), "Make Decoy Run")

    def test_pages_are_plain(self):
        for page in (*PAGES, *OTHER_PAGES):
            if not MADE & set(page.relative_to(ROOT).parts):
                self.assert_plain(page.read_text(), page=page.name)

    def test_notebooks_are_plain(self):
        for path in sorted((ROOT / "notebooks").glob("*.ipynb")):
            for cell in json.loads(path.read_text())["cells"]:
                if cell["cell_type"] == "markdown":
                    self.assert_plain("".join(cell["source"]), page=path.name)

    def test_the_help_is_plain(self):
        for name, parser in parsers(make_parser()):
            self.assertIsInstance(parser, argparse.ArgumentParser)
            self.assert_plain(parser.format_help(), command=name)

    def test_templates_are_plain(self):
        templates = sorted(PACKAGE.rglob("*.j2"))
        self.assertTrue(templates)
        for path in templates:
            text = template_text(path.read_text())
            self.assert_plain(text, file=str(path.relative_to(ROOT)))

    def test_docstrings_and_messages_are_plain(self):
        for path in sorted(PACKAGE.rglob("*.py")):
            for line, text in prose_of(path):
                place = f"{path.relative_to(ROOT)}:{line}"
                self.assert_plain(text, place=place)

    def test_public_names_are_plain(self):
        for path in sorted(PACKAGE.rglob("*.py")):
            for name in names_of(path):
                if name.startswith("_") or name in KEPT_NAMES:
                    continue
                place = str(path.relative_to(ROOT))
                self.assert_plain(words_of(name), place=place, name=name)


if __name__ == "__main__":
    unittest.main()
