"""A training run on disk: what it was started with, and how far it is."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import torch
from pydrake.common.yaml import yaml_dump_typed

from brace_drake.core.csv_text import csv_text
from brace_drake.core.errors import BraceError, PolicyError
from brace_drake.core.output import HoldFolder, WriteBytes, WriteJson, WriteText
from brace_drake.core.reading import (
    LoadJson,
    ReadBytes,
    check_file,
    decode,
    in_file,
    parse_yaml,
)
from brace_drake.core.versions import installed_versions
from brace_drake.learning.task import LearningTask, load_task_scenario
from brace_drake.learning.training.numbers import TrainingNumbers
from brace_drake.report.canvas import make_figure
from brace_drake.scenario.load import LoadRecord, LoadScenario

PACKAGES = (
    "brace_drake", "drake", "numpy", "numba", "gymnasium", "torch",
    "stable-baselines3",
)  # fmt: skip
CHECKPOINT = "checkpoint.pt"
_CHECKPOINT_MB = 2000
# Of what a checkpoint holds and how a run goes on from it.
_FORMAT = 2
SCENARIO = "used.scenario.yaml"
# What a checkpoint is made of beside tensors and plain values.
_ARRAYS = (
    np._core.multiarray.scalar,
    np._core.multiarray._reconstruct,
    np.ndarray,
    np.dtype,
    *(
        type(np.dtype(kind))
        for kind in ("bool", "f4", "f8", "i4", "i8", "u4", "u8")
    ),
)


def WriteStart(
    folder: Path, task: LearningTask, numbers: TrainingNumbers
) -> None:
    """Writes task, hyper-parameters, the scenario, seed and versions.

    The folder is held; to be released when the run ends.

    Raises:
        OutputError: The folder cannot be written, or another process holds it.
    """
    HoldFolder(folder)
    scenario = load_task_scenario(task)
    for name, record in (
        ("task.yaml", task),
        ("training.yaml", numbers),
        (SCENARIO, scenario),
    ):
        WriteText(folder / name, yaml_dump_typed(record))
    WriteJson(
        folder / "manifest.json",
        {"seed": numbers.seed, "versions": installed_versions(PACKAGES)},
    )


def LoadStart(folder: Path) -> tuple[LearningTask, TrainingNumbers]:
    """What a run was started with; its scenario is the one it kept.

    Raises:
        PolicyError: There is no run, its manifest is damaged, or other
            versions have begun it.
        ScenarioError: A file of it cannot be read.
    """
    manifest = folder / "manifest.json"
    if not (manifest.is_file() and (folder / CHECKPOINT).is_file()):
        raise PolicyError(f"{folder}: no training run to continue")
    begun, here = _load_versions(manifest), installed_versions(PACKAGES)
    for name, value in begun.items():
        if here.get(name) != value:
            raise PolicyError(
                f"{folder}: begun with {name} {value}; here is"
                f" {here.get(name)}: a run continues with the same alone"
            )
    task = LoadRecord(LearningTask(), folder / "task.yaml")
    kept = folder / SCENARIO
    if not _is_same(task, kept):
        task.scenario = str(kept)
    return task, LoadRecord(TrainingNumbers(), folder / "training.yaml")


def CheckSame(
    folder: Path, task: LearningTask, numbers: TrainingNumbers
) -> None:
    """Refuses to continue a run of another task, scenario or numbers.

    Where the scenario's file lies does not matter, what is in it does.

    Raises:
        PolicyError: Names the first key that differs, and both values.
        ScenarioError: A file of the run cannot be read.
    """
    for name, kept, asked in (
        ("task.yaml", LoadRecord(LearningTask(), folder / "task.yaml"), task),
        ("training.yaml",
         LoadRecord(TrainingNumbers(), folder / "training.yaml"), numbers),
        (SCENARIO, LoadScenario(folder / SCENARIO), load_task_scenario(task)),
    ):  # fmt: skip
        kept, asked = (parse_yaml(yaml_dump_typed(r)) for r in (kept, asked))
        for key, value in asked.items():
            if key != "scenario" and kept.get(key) != value:
                raise PolicyError(
                    f"{folder / name}: {key}: begun with {kept.get(key)!r},"
                    f" asked for is {value!r}: another folder, or the same"
                    " options"
                )


def _load_versions(manifest: Path) -> dict:
    try:
        return dict(LoadJson(manifest, PolicyError)["versions"])
    except (PolicyError, ValueError, KeyError, TypeError) as error:
        raise PolicyError(
            f"{manifest}: no manifest of a training run"
        ) from error


def _is_same(task: LearningTask, kept: Path) -> bool:
    """Whether the scenario that a task names is still the one that it kept."""
    try:
        text = yaml_dump_typed(load_task_scenario(task))
    except BraceError:
        return False
    with in_file(kept, PolicyError):
        return text == decode(ReadBytes(kept))


def WriteCheckpoint(folder: Path, state: dict) -> None:
    """Writes the state of a run; a kill leaves the old one or the new one."""
    memory = io.BytesIO()
    torch.save({"format": _FORMAT, **state}, memory)
    WriteBytes(folder / CHECKPOINT, memory.getvalue())


def LoadCheckpoint(folder: Path) -> dict:
    """Reads what `WriteCheckpoint` has written: arrays and plain values alone.

    Raises:
        PolicyError: The file is damaged, holds anything that could run code,
            or is of another format.
    """
    path = folder / CHECKPOINT
    try:
        check_file(path, _CHECKPOINT_MB)
        with torch.serialization.safe_globals(_ARRAYS):
            state = torch.load(path, weights_only=True)
        found = state.get("format", 1)
    # On a broken file torch may raise any exception.
    except Exception as error:
        raise PolicyError(f"{path}: no checkpoint of a training run") from error
    if found != _FORMAT:
        raise PolicyError(
            f"{path}: format {found}; allowed: {_FORMAT}: begun by a version"
            " that trains otherwise; train anew in another folder"
        )
    return state


def WriteCurve(folder: Path, rows: list[dict[str, float]]) -> None:
    """Writes the training curve as CSV."""
    WriteText(folder / "curve.csv", csv_text(list(rows[0]), rows))


def DrawCurve(folder: Path, rows: list[dict[str, float]]) -> None:
    """Draws returns over decisions as PNG."""
    figure = make_figure(7, 4)
    axes = figure.add_subplot()
    steps = [row["steps"] for row in rows]
    for name, label, style in (
        ("episode_return", "while training", "-"),
        ("evaluation", "mean actions, the same subjects", "o"),
    ):
        axes.plot(steps, [row[name] for row in rows], style, label=label)
    axes.set_xlabel("decisions")
    axes.set_ylabel("return of an episode")
    axes.legend()
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=120)
    WriteBytes(folder / "curve.png", memory.getvalue())
