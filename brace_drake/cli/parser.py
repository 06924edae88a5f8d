"""The parser of the command line: one line for what is wrong."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from typing import NoReturn

from brace_drake.core.errors import suggest


class OneLineParser(argparse.ArgumentParser):
    """Says what is wrong with the arguments in one line, without the usage,
    and which command or option may have been meant.
    """

    _given: Sequence[str] = ()

    def parse_known_args(self, args=None, namespace=None):  # type: ignore
        """Nothing may be left: each command tells of its own options."""
        args = sys.argv[1:] if args is None else list(args)
        self._given = args
        found, left = super().parse_known_args(args, namespace)
        if left:
            words = " ".join(left)
            _, hint = self._meant(left)
            self.error(f"unrecognized arguments: {words}{hint}")
        return found, left

    def _check_value(self, action, value) -> None:
        if value == "" and action.const != "":
            # As a path it would be the folder that one stands in; and nothing
            # else has a meaning without a letter.
            raise argparse.ArgumentError(action, "nothing is given")
        if action.choices is not None and value not in action.choices:
            hint = suggest(value, action.choices)
            if hint:
                text = f"invalid choice: {value!r}{hint}"
                raise argparse.ArgumentError(action, text)
        super()._check_value(action, value)

    def _meant(self, words: Iterable[str]) -> tuple[str, str]:
        """The first option that is none, and a hint at what was meant."""
        known = list(self._option_string_actions)
        for word in words:
            name = word.partition("=")[0]
            is_known = any(option.startswith(name) for option in known)
            if name.startswith("--") and not is_known:
                return name, suggest(name, known)
        return "", ""

    def error(self, message: str) -> NoReturn:
        text = " ".join(message.split())
        name, hint = self._meant(self._given)
        if hint and "arguments are required" in text:
            text += f"; no option {name}{hint}"
        self.exit(2, f"brace-drake: {text}; see {self.prog} --help\n")
