"""Words that are out stay out of pages, help, messages, comments and names."""

import argparse
import ast
import io
import json
import re
import tokenize
import unittest
from pathlib import Path

from brace_drake.cli.main import make_parser
from tests.test_documentation import MADE, PAGES, parsers

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "brace_drake"
TABLE = ROOT / "tests" / "data" / "words_out.txt"
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
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


def strings_in(source):
    """Strings of a program, docstrings among them, with their lines."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def prose_of(path):
    """Docstrings and messages of a module, with their lines."""
    for line, text in strings_in(path.read_text()):
        if re.search(r"\S\s\S", text):
            yield line, text


def comments_in(source):
    """Comments of a program, with their lines; neighbours are one text."""
    line, text, last = 0, [], 0
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type != tokenize.COMMENT:
            continue
        if text and token.start[0] != last + 1:
            yield line, " ".join(text)
            text = []
        last = token.start[0]
        line = line if text else last
        text.append(token.string.lstrip("#: "))
    if text:
        yield line, " ".join(text)


def cells_of(path, kind):
    """Texts of a notebook's cells of a kind, markdown or code."""
    for cell in json.loads(path.read_text())["cells"]:
        if cell["cell_type"] == kind:
            yield "".join(cell["source"])


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

    def test_strings_and_comments_are_found(self):
        source = (
            "# It is led\n# back.\nx = f'a {x} stray'  # No end.\n\n# Apart."
        )
        self.assertEqual(
            list(comments_in(source)),
            [(1, "It is led back. No end."), (5, "Apart.")],
        )
        self.assertEqual(list(strings_in(source)), [(3, "a "), (3, " stray")])

    def test_pages_are_plain(self):
        for page in (*PAGES, *OTHER_PAGES):
            if not MADE & set(page.relative_to(ROOT).parts):
                self.assert_plain(page.read_text(), page=page.name)

    def test_notebooks_are_plain(self):
        self.assertTrue(NOTEBOOKS)
        for path in NOTEBOOKS:
            for text in cells_of(path, "markdown"):
                self.assert_plain(text, page=path.name)

    def test_comments_and_strings_of_notebooks_are_plain(self):
        for path in NOTEBOOKS:
            for source in cells_of(path, "code"):
                for line, text in (*strings_in(source), *comments_in(source)):
                    self.assert_plain(text, page=path.name, line=line)

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

    def test_comments_are_plain(self):
        for path in sorted(PACKAGE.rglob("*.py")):
            for line, text in comments_in(path.read_text()):
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
