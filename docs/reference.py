"""Pages that are made from the code: entry points, parts, all commands."""

from __future__ import annotations

import argparse
import ast
import importlib
import inspect
import pkgutil
from pathlib import Path

import brace_drake

# Their page is that of the commands.
_SKIPPED = {"cli"}
# What a program of one's own calls first, task by task.
ENTRY_POINTS = {
    "Read, check, write and import a campaign": (
        "brace_drake.recording.LoadCampaign",
        "brace_drake.recording.CheckCampaign",
        "brace_drake.recording.WriteCampaign",
        "brace_drake.recording.importing.mapped.ImportCampaign",
    ),
    "Write what a diagnosis has found": (
        "brace_drake.document.document.MakeDocument",
        "brace_drake.report.WriteReport",
        "brace_drake.validation.repaired.WriteRepairedScenario",
    ),
    "Fit a subject, plan a campaign": (
        "brace_drake.identification.subject.campaign_fit.fit_campaign",
        "brace_drake.design.plan.plan_campaign",
        "brace_drake.devices.motions.library.MakeMotion",
    ),
    "Read a scenario, simulate it": (
        "brace_drake.scenario.load.LoadScenario",
        "brace_drake.scenario.load.SaveScenario",
        "brace_drake.model.brace_station.MakeControlledBrace",
        "brace_drake.model.simulate.RecordBrace",
    ),
    "Add an effect or a device": (
        "brace_drake.effects.card.Effect",
        "brace_drake.effects.registry.register_effect",
        "brace_drake.effects.registry.effects_for",
        "brace_drake.devices.registry.register_device",
    ),
    "Make a torso, run a policy, control a brace": (
        "brace_drake.torso.personalize.personalize",
        "brace_drake.learning.policy.LoadPolicy",
        "brace_drake.experiments.compare.compare_controllers",
    ),
    "Catch every error that is for the caller": (
        "brace_drake.core.errors.BraceError",
    ),
}


def WriteReference(folder: Path, parser: argparse.ArgumentParser) -> None:
    """Writes api.md, a page of each part, and commands.md into a folder.

    Pages of parts that are no longer there are removed.
    """
    folder.mkdir(exist_ok=True)
    found = pkgutil.iter_modules(brace_drake.__path__)
    parts = [m for m in found if m.name not in _SKIPPED]
    pages = {f"{part.name}.md": _part_page(part) for part in parts}
    pages["api.md"] = _api_page([part.name for part in parts])
    pages["commands.md"] = _commands_page(parser)
    for name, text in pages.items():
        _WriteChanged(folder / name, text)
    for path in folder.glob("*.md"):
        if path.name not in pages:
            path.unlink()


def _api_page(parts: list[str]) -> str:
    """Entry points first, then every part with what it is for."""
    lines = ["# API reference", "", *_top_level()]
    lines += ["## Entry points", ""]
    for task, names in ENTRY_POINTS.items():
        lines += [f"**{task}**", ""]
        lines += [f"- {{py:obj}}`{n}`: {_meaning(n)}" for n in names]
        lines.append("")
    lines += ["## Parts of the package", ""]
    for part in parts:
        meaning = _first_line(importlib.import_module(f"brace_drake.{part}"))
        lines.append(f"- [{part}]({part}.md): {meaning}")
    toctree = "\n".join(parts)
    lines += ["", f"```{{toctree}}\n:hidden:\n\n{toctree}\n```", ""]
    return "\n".join(lines)


def _top_level() -> list[str]:
    """What `import brace_drake` offers, documented in full."""
    lines = []
    for name in getattr(brace_drake, "__all__", ()):
        kind = _kind_of(getattr(brace_drake, name))
        if kind is not None:
            lines += [f".. {kind}:: brace_drake.{name}", "   :no-index:"]
            lines += ["   :members:", ""] if kind == "autoclass" else [""]
    if not lines:
        return []
    text = "\n".join(lines)
    head = "## `import brace_drake`"
    return [head, "", f"```{{eval-rst}}\n{text}```", ""]


def _kind_of(value) -> str | None:
    """The directive that documents a value; None for what has no text."""
    if inspect.isclass(value):
        return "autoclass"
    return "autofunction" if inspect.isroutine(value) else None


def _meaning(name: str) -> str:
    """The first line of an entry point's docstring."""
    module, _, attribute = name.rpartition(".")
    return _first_line(getattr(importlib.import_module(module), attribute))


def _first_line(value) -> str:
    """The first sentence of a docstring, on one line."""
    return " ".join((inspect.getdoc(value) or "").split("\n\n")[0].split())


def _part_page(part) -> str:
    """The part itself, then its modules: first those that it offers."""
    name = f"brace_drake.{part.name}"
    blocks = []
    for module in [name, *(_modules_of(part, name) if part.ispkg else ())]:
        head = "#" if module == name else "##"
        blocks.append(
            f"{head} {module}\n\n```{{eval-rst}}\n.. automodule:: {module}\n"
            "   :members:\n   :show-inheritance:\n```\n"
        )
    return "\n".join(blocks)


def _modules_of(part, name: str) -> list[str]:
    """Modules with entry points, those that the package imports, the rest."""
    path = Path(brace_drake.__path__[0]) / part.name
    walked = [m.name for m in pkgutil.walk_packages([str(path)], f"{name}.")]
    entries = [n.rpartition(".")[0] for g in ENTRY_POINTS.values() for n in g]
    tree = ast.parse((path / "__init__.py").read_text())
    offered = [n.module for n in tree.body if isinstance(n, ast.ImportFrom)]
    first = [m for m in dict.fromkeys(entries + offered) if m in walked]
    return first + [module for module in walked if module not in first]


def _commands_page(parser: argparse.ArgumentParser) -> str:
    blocks = [
        "# Commands\n\nWhat `brace-drake COMMAND --help` prints. Exit codes:"
        " [the command line](../command_line.md).\n"
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
