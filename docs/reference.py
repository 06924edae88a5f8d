"""Pages that are made from the code: one per part, one of all commands."""

from __future__ import annotations

import argparse
import pkgutil
from pathlib import Path

import brace_drake

# What the reader of a part's page is told first.
_SKIPPED = {"cli"}


def WriteReference(folder: Path, parser: argparse.ArgumentParser) -> None:
    """Writes api.md, a page of each part, and commands.md into a folder.

    Pages of parts that are no longer there are removed.
    """
    folder.mkdir(exist_ok=True)
    parts = [
        m
        for m in pkgutil.iter_modules(brace_drake.__path__)
        if m.name not in _SKIPPED
    ]
    pages = {f"{part.name}.md": _part_page(part) for part in parts}
    names = "\n".join(part.name for part in parts)
    pages["api.md"] = (
        "# API reference\n\nFrom the docstrings, a page for each part of the"
        " package.\n\n```{toctree}\n:maxdepth: 1\n\n" + names + "\n```\n"
    )
    pages["commands.md"] = _commands_page(parser)
    for name, text in pages.items():
        _WriteChanged(folder / name, text)
    for path in folder.glob("*.md"):
        if path.name not in pages:
            path.unlink()


def _part_page(part) -> str:
    name = f"brace_drake.{part.name}"
    modules = [name]
    if part.ispkg:
        path = Path(brace_drake.__path__[0]) / part.name
        walked = pkgutil.walk_packages([str(path)], f"{name}.")
        modules += [module.name for module in walked]
    blocks = []
    for module in modules:
        head = "#" if module == name else "##"
        blocks.append(
            f"{head} {module}\n\n```{{eval-rst}}\n.. automodule:: {module}\n"
            "   :members:\n   :show-inheritance:\n```\n"
        )
    return "\n".join(blocks)


def _commands_page(parser: argparse.ArgumentParser) -> str:
    blocks = [
        "# Commands\n\nWhat `brace-drake COMMAND --help` prints. Exit codes:"
        " [the command line](../guides/command_line.md).\n"
    ]
    for action in parser._subparsers._group_actions:
        for name, command in action.choices.items():
            help_text = command.format_help()
            blocks.append(f"## {name}\n\n```text\n{help_text}```\n")
    return "\n".join(blocks)


def _WriteChanged(path: Path, text: str) -> None:
    """Writes only what is new, so that a second build is quick."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
