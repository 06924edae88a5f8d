"""Files are opened, bounded and taken apart without surprises."""

import math
import os
import socket
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import yaml

from brace_drake.core.errors import (
    CampaignError,
    ReadError,
    is_plain,
    one_line,
    suggest,
)
from brace_drake.core.output import WriteText
from brace_drake.core.reading import (
    LoadJson,
    LoadYaml,
    ReadBytes,
    parse_json,
    parse_yaml,
)
from brace_drake.core.reading.files import MOST_MB
from brace_drake.core.resources import scenario_path
from tests.reader_fuzz import time_limit

LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 10)}]\n"
    for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)


class TestOpener(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def assert_refused(self, path, *words):
        with self.assertRaises(ReadError) as caught, time_limit(2.0):
            ReadBytes(path)
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_what_is_no_file_is_refused_without_waiting(self):
        os.mkfifo(self.folder / "pipe")
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(self.folder / "socket"))
            self.assert_refused(self.folder / "pipe", "is a pipe")
            self.assert_refused(self.folder / "socket", "is a socket")
        for path in ("/dev/zero", "/dev/tty", "/dev/ptmx"):
            self.assert_refused(path, "is a device")
        self.assert_refused(self.folder, "is a folder")

    def test_names_that_no_file_can_have(self):
        for name in ("\ud800", "a\0b", "x" * 5000):
            self.assert_refused(name, "cannot be read")

    def test_a_bound_on_the_size_and_how_to_set_it(self):
        path = self.folder / "large"
        with path.open("wb") as file:
            file.truncate(200_000_000)
        self.assert_refused(path, "200 MB", "128 MB", MOST_MB)
        path.write_bytes(b"x" * 2_000_000)
        with self.assertRaisesRegex(ReadError, "has 2 MB; allowed: 1 MB"):
            ReadBytes(path, 1)
        for asked, good in (("3", True), ("0.1", False)):
            with mock.patch.dict(os.environ, {MOST_MB: asked}):
                if good:
                    self.assertEqual(len(ReadBytes(path, 1)), 2_000_000)
                else:
                    self.assertRaises(ReadError, ReadBytes, path, 1)
        for asked in ("x", "nan", "-1"):
            with mock.patch.dict(os.environ, {MOST_MB: asked}):
                self.assert_refused(path, MOST_MB, "allowed")


class TestYaml(unittest.TestCase):
    def assert_refused(self, text, *words):
        with self.assertRaises(ReadError) as caught, time_limit(5.0):
            parse_yaml(text)
        message = str(caught.exception)
        self.assertNotIn("\n", message)
        self.assertLess(len(message), 300)
        for word in words:
            self.assertIn(word, message)

    def test_own_files_mean_what_they_meant(self):
        for path in scenario_path("").glob("*.yaml"):
            text = path.read_text()
            self.assertEqual(
                repr(parse_yaml(text)), repr(yaml.safe_load(text)), path
            )

    def test_aliases_that_multiply(self):
        self.assert_refused(LAUGHS, "line 6", "aliases")
        self.assert_refused("a: &a [*a]", "alias *a")
        self.assert_refused("&a a: *b", "alias *b")

    def test_aliases_and_taken_over_keys_within_bounds(self):
        text = "a: &a {x: 1, y: 2}\nb: {<<: *a, y: 3}\nc: [*a, *a]"
        found = parse_yaml(text)
        self.assertEqual(found["b"], {"x": 1, "y": 3})
        self.assertEqual(found["c"], [found["a"]] * 2)
        self.assert_refused("a: {<<: 3}", "<<")

    def test_depth_and_length(self):
        for text in ("a: " + "[" * 5000, "a: " + "{a: " * 5000):
            self.assert_refused(text, "32 levels")
        self.assert_refused("a: " + "- " * 5000, "line 1")
        self.assert_refused(f"a: {'x' * 20_000}", "20000 characters")
        self.assert_refused(f"a: [{'1,' * 300_000}]", "200000 values")

    def test_numbers_are_decimal_and_anything_else_is_a_word(self):
        words = (
            *("0x1F", "0b11", "0o17", "017", "1:30:00", "1:30.5", "9" * 400),
            *("2024-99-99", "2024-01-01", "2001-12-14t21:59:43.10-05:00"),
            *("1e3", "1_0e", "2_00", "1_0", "1_0.5", "1_000_00"),
            *("0x" + "f" * 400, "=", "<"),
        )
        for word in words:
            self.assertEqual(parse_yaml(f"a: {word}"), {"a": word})
        for text, value in (
            *(
                ("1_000", 1000),
                ("12_000_000", 12000000),
                ("-7", -7),
                ("1.5e+3", 1500.0),
                ("+0.5", 0.5),
            ),
            *((".inf", math.inf), ("yes", True), ("off", False), ("~", None)),
            *(('"7"', "7"), ("!!str 7", "7"), ("! 7", "7"), ("!!int 7", 7)),
        ):
            found = parse_yaml(f"a: {text}")["a"]
            self.assertEqual((found, type(found)), (value, type(value)))
        self.assert_refused("a: 1.0e+999", "beyond any number")

    def test_a_key_is_there_once(self):
        self.assert_refused("a: 1\nb:\n  c: 1\n  c: 2", "line 4", "'c'")
        self.assert_refused("{a: 1, 'a': 2}", "'a'", "twice")
        self.assert_refused("? [a]\n: 1", "as a key")
        self.assert_refused("a: &x [1]\n*x : 2", "as a key")

    def test_a_key_is_a_word_or_a_whole_number(self):
        # In Python 1, 1.0 and true are one key.
        words = '1: a\n"1": b\n"true": c\n"1.0": d\n"": e'
        found = {1: "a", "1": "b", "true": "c", "1.0": "d", "": "e"}
        self.assertEqual(parse_yaml(words), found)
        for key, word in (
            *(("true", "true or false"), ("on", "true or false")),
            *(("~", "null"), ("1.0", "1.0"), (".nan", "nan")),
        ):
            for text in (f"1: a\n{key}: b", f"x: &k {key}\n*k : b"):
                with self.subTest(text):
                    self.assert_refused(text, "line 2", "key that is", word)

    def test_what_is_no_yaml_of_ours(self):
        for text, word in (
            ("a: !!python/object/apply:os.system [x]", "tag"),
            ("a: !!timestamp 2020-01-01", "tag"),
            ("a: !foo 1", "tag"),
            ("a: !!int x", "tag"),
            ("a: 1\n---\nb: 2", "second document"),
            ("a: \0", "null"),
            ('a: "\\e[31m"', "control"),
            ('a: "\\ud800"', "line 1"),
            ("\ud800: 1", "not YAML"),
            (b"a: 1\nb: \xff", "line 2"),
            ("", "found nothing"),
            ("- 1", "found a list"),
            ("secret", "found a text"),
        ):
            with self.subTest(text):
                self.assert_refused(text, word)
        self.assertEqual(parse_yaml("# nothing", may_be_empty=True), {})

    def test_files_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "x.yaml"
            path.write_text("a: 1\na: 2\n")
            with self.assertRaisesRegex(CampaignError, "x.yaml: not YAML in"):
                LoadYaml(path, CampaignError)
            path.write_text("[1")
            with self.assertRaisesRegex(CampaignError, "x.yaml: not JSON"):
                LoadJson(path, CampaignError)


class TestJson(unittest.TestCase):
    def test_what_is_refused(self):
        for text, word in (
            (b"[" * 100_000, "levels"),
            (b"[" * 80 + b"]" * 80, "64 levels"),
            (b'{"a": 1, "b": 2, "a": 3}', "'a'"),
            (b'{"a": NaN}', "NaN"),
            (b"[-Infinity]", "-Infinity"),
            (b"1e999", "beyond"),
            (b"9" * 400, "400 digits"),
            (b"9" * 5000, "5000 digits"),
            (b"\xff", "UTF-8"),
            (b"{", "not JSON"),
            (b"[" + b"[]," * 8_000_000, "16 MB"),
            (b"", "not JSON"),
        ):
            with self.assertRaisesRegex(ReadError, word), time_limit(2.0):
                parse_json(text)

    def test_what_is_read(self):
        found = parse_json(b'\xef\xbb\xbf{"a": [1, 2.5, null, true, "x"]}')
        self.assertEqual(found, {"a": [1, 2.5, None, True, "x"]})


class TestNames(unittest.TestCase):
    def test_no_message_has_what_a_terminal_obeys(self):
        name = "a\x1b[31m\ud800\u202eb\x9b\nc\td"
        self.assertEqual(
            str(CampaignError(name)), r"a\x1b[31m\ud800\u202eb\x9b c d"
        )
        self.assertTrue(is_plain(one_line(name)))
        self.assertLess(len(str(CampaignError("x" * 10**6))), 5000)
        self.assertEqual(one_line("Größe  Δ m²"), "Größe  Δ m²")

    def test_hints_among_many_and_long_words_take_no_time(self):
        with time_limit(2.0):
            suggest("x" * 10**6, ["x" * 10**6] * 10)
            suggest("time", [f"column {i}" for i in range(100_000)])

    def test_a_surrogate_is_written_as_an_escape(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "x.html"
            WriteText(path, "\ud800")
            self.assertEqual(path.read_text(), r"\ud800")


if __name__ == "__main__":
    unittest.main()
