"""The function that makes a user's diagram."""

from __future__ import annotations

import importlib
import inspect
import sys
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from pathlib import Path

from pydrake.systems.framework import Diagram

from brace_drake.core.errors import ScenarioError, suggest

MakeDiagram = Callable[..., Diagram]


def find_factory(name: str) -> MakeDiagram:
    """The function of a text module:function, or file.py:function.

    It is imported, which runs its module: only what the caller names is.

    Raises:
        ScenarioError: One line: there is no such module or function, or
            importing it fails.
    """
    place, _, function = name.rpartition(":")
    if not place or not function:
        raise ScenarioError(
            f"--diagram {name}: allowed: module:function, as in arm:MakeArm"
        )
    try:
        with redirect_stdout(sys.stderr):
            module = _import(place)
    except ModuleNotFoundError as error:
        if error.name != place.split(".")[0]:
            raise ScenarioError(f"--diagram {name}: {error}") from error
        raise ScenarioError(
            f"--diagram {name}: no module {place} here or installed"
        ) from error
    except (Exception, SystemExit) as error:
        kind = type(error).__name__
        raise ScenarioError(f"--diagram {name}: {kind}: {error}") from error
    found = getattr(module, function, None)
    if not callable(found):
        functions = [n for n, v in vars(module).items() if callable(v)]
        hint = suggest(function, functions)
        raise ScenarioError(
            f"--diagram {name}: {place} has no function {function}{hint}"
        )
    return found


def _import(place: str):
    if not place.endswith(".py"):
        # Of the folder that the command is called in, as `python -m` has it.
        here = str(Path.cwd())
        if here not in sys.path:
            sys.path.insert(0, here)
        return importlib.import_module(place)
    path = Path(place)
    if not path.is_file():
        raise ModuleNotFoundError(f"no file {place}", name=place.split(".")[0])
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


def call_factory(make: MakeDiagram, numbers: Mapping[str, float]) -> Diagram:
    """The diagram of some numbers; a function without arguments is not given
    them.

    Raises:
        ScenarioError: It fails, or returns no diagram.
    """
    name = getattr(make, "__name__", "the function")
    try:
        takes = inspect.signature(make).parameters
        # What the caller's code prints is no result of ours.
        with redirect_stdout(sys.stderr):
            diagram = make(dict(numbers)) if takes else make()
    except (Exception, SystemExit) as error:
        kind = type(error).__name__
        raise ScenarioError(f"{name}: {kind}: {error}") from error
    if not isinstance(diagram, Diagram):
        kind = type(diagram).__name__
        raise ScenarioError(f"{name} returns a {kind}, not a Diagram")
    return diagram
